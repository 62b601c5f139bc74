// Table: named columns and rows of words and numbers, for error measures and the like.
#pragma once
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "graph/json.h"
#include "runtime/value.h"

namespace weft {

class Table {
  public:
    using Cell = std::variant<std::string, double>;

    Table() = default;
    explicit Table(std::vector<std::string> column_names, std::string title_text = {})
        : title(std::move(title_text)), columns(std::move(column_names)) {}

    std::string title;  // above the text forms; may be empty
    std::vector<std::string> columns;
    std::vector<std::vector<Cell>> rows;  // each as long as `columns`

    void add(std::vector<Cell> row);  // shorter rows are filled up with empty words
    void append(const Table& other);  // its rows; columns new to us are added
    const Cell* find(size_t row, std::string_view column) const;

    std::string text() const;      // aligned, for a terminal; numbers with 5 digits
    std::string markdown() const;  // the same as a table of a README
    std::string csv() const;       // all digits, RFC 4180
    Json json() const;  // a list of objects by column; what JSON has no number for is a text

    size_t bytes() const;
    void count(Items& items) const { items.add("rows", rows.size()); }
};

// The form that a file's extension asks for: .md, .csv, .json, anything else text.
std::string table_as(const Table& table, std::string_view path);

WEFT_VALUE_TYPE(Table, "Table", "named columns and rows")

}  // namespace weft
