// Keys: what a value is made of, known before it is made. Two values with the same key have the
// same bits. A key is a hash of the node's type and version, its parameters, the keys of what comes
// in, the content of the files it reads, and the instruction set. Names of nodes and of files
// written, "about", "layout", threads, tiles and shards do not enter; the path of a file read does
// not either, only what is in it. Where many links end at one input, the names of the nodes linked
// do: such nodes write them down.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/plan.h"
#include "runtime/provenance.h"

namespace weft {

struct Key {
    std::uint64_t high = 0, low = 0;
    bool operator==(const Key&) const = default;
    auto operator<=>(const Key&) const = default;
    std::string text() const;  // 32 hex digits
};

struct Keys {
    std::vector<std::vector<Key>>
        outputs;  // of every output of every node of the graph, streams too
    Key run;      // of all that the graph writes and puts out
    Key of(Link link) const { return outputs[size_t(link.node)][size_t(link.port)]; }
};

// Source: XXH3, 128 bits, over one line of JSON a node.
Keys make_keys(const Plan& plan, const FilesRead& files);

}  // namespace weft
