// Documents held against a schema by a validator of its own: python3-jsonschema.
#pragma once
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "graph_of.h"

namespace weft::test {

// The interpreter that has jsonschema: the system's, before any other in the path; "" if there is
// none.
inline std::string python_with_jsonschema() {
    for (const char* candidate : {"/usr/bin/python3", "python3"})
        if (std::system((std::string(candidate) + " -c 'import jsonschema' 2>/dev/null").c_str()) ==
            0)
            return candidate;
    return "";
}

// "name yes" or "name no" of each document, a line each. Comments are taken out first.
inline std::string verdicts(const Folder& folder, const Json& schema,
                            const std::vector<std::string>& documents) {
    constexpr const char* validate = R"(
import json, re, sys
from jsonschema import Draft202012Validator
schema = json.load(open(sys.argv[1]))
Draft202012Validator.check_schema(schema)
validator = Draft202012Validator(schema)
for name in sys.argv[2:]:
    text = re.sub(r'^\s*// .*$', '', open(name).read(), flags=re.M)
    errors = list(validator.iter_errors(json.loads(text)))
    print(name.rsplit('/', 1)[1], 'no' if errors else 'yes')
)";
    std::string command = python_with_jsonschema() + " " + folder.write("validate.py", validate) +
                          " " + folder.write("schema.json", schema.dump(true));
    for (const std::string& document : documents) command += " " + document;
    command += " > " + (folder / "verdicts");
    EXPECT_EQ(std::system(command.c_str()), 0);
    std::ifstream in(folder / "verdicts");
    return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace weft::test
