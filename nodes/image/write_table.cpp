// write-table: a table to a file (.md, .csv, .json, anything else: aligned text) or, named "-", to
// standard output. Several tables become one, row under row.
#include <fmt/format.h>

#include <cstdio>

#include "image/table.h"
#include "runtime/atomic_file.h"
#include "runtime/node.h"

namespace weft {
namespace {

enum class TableForm { automatic, text, markdown, csv, json };
constexpr const char* extensions[] = {"", ".txt", ".md", ".csv", ".json"};

struct WriteTable {
    OutputFile file{"-"};
    TableForm form = TableForm::automatic;
    std::string title;

    static void declare(Ports<WriteTable>& node) {
        node.about("writes tables as text, markdown, CSV or JSON")
            .in<Table>("table", "tables, joined row under row", Need::variadic)
            .param("file", &WriteTable::file, {.about = "where to; '-' is standard output"})
            .choice("format", &WriteTable::form, {"default", "text", "markdown", "csv", "json"},
                    {.about = "default: by the extension, text where it says nothing"})
            .param("title", &WriteTable::title, {.about = "above text and markdown"})
            .writes();
    }

    void run(const Inputs& in, Outputs&, Context&) const {
        Table all;
        for (const Table* table : in.all<Table>("table")) {
            if (all.title.empty()) all.title = table->title;
            all.append(*table);
        }
        if (!title.empty()) all.title = title;
        const std::string text =
            table_as(all, form == TableForm::automatic ? file.path : extensions[int(form)]);
        if (file.path != "-") return write_file(file.path, text);
        std::fwrite(text.data(), 1, text.size(), stdout);
        if (std::fflush(stdout) != 0) throw Error("standard output cannot be written");
    }
};

WEFT_NODE(WriteTable, "write-table", 1);

}  // namespace
}  // namespace weft
