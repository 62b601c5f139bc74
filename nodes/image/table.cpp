#include "image/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace weft {
namespace {

std::string short_form(const Table::Cell& cell) {
    if (const auto* word = std::get_if<std::string>(&cell)) return *word;
    return fmt::format("{:.5g}", std::get<double>(cell));
}

std::string full_form(const Table::Cell& cell) {
    if (const auto* word = std::get_if<std::string>(&cell)) return *word;
    return fmt::format("{}", std::get<double>(cell));
}

// Letters of UTF-8 text: bytes that do not go on a letter.
size_t letters(std::string_view text) {
    return size_t(
        std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

// Rows of cells joined by `between`, padded to the widest of their column; numbers to the right.
std::string aligned(const Table& table, std::string_view before, std::string_view between,
                    std::string_view after, bool rule) {
    std::vector<size_t> widths;
    std::vector<bool> numbers(table.columns.size(), !table.rows.empty());
    for (size_t c = 0; c < table.columns.size(); ++c) {
        size_t width = std::max<size_t>(letters(table.columns[c]), rule ? 3 : 0);
        for (const auto& row : table.rows) {
            width = std::max(width, letters(short_form(row[c])));
            if (const auto* word = std::get_if<std::string>(&row[c]))
                numbers[c] = numbers[c] && word->empty();
        }
        widths.push_back(width);
    }
    const auto line = [&](auto&& cell) {
        std::string text(before);
        for (size_t c = 0; c < widths.size(); ++c) {
            const std::string value = cell(c);
            const std::string space(widths[c] - letters(value), ' ');
            text += (c ? std::string(between) : "") + (numbers[c] ? space + value : value + space);
        }
        text += after;
        while (!text.empty() && text.back() == ' ') text.pop_back();
        return text + "\n";
    };
    std::string text = line([&](size_t c) { return table.columns[c]; });
    if (rule)
        text += line(
            [&](size_t c) { return std::string(widths[c] - 1, '-') + (numbers[c] ? ":" : "-"); });
    for (const auto& row : table.rows) text += line([&](size_t c) { return short_form(row[c]); });
    return text;
}

std::string quoted(const std::string& word) {
    if (word.find_first_of(",\"\r\n") == std::string::npos) return word;
    std::string text = "\"";
    for (const char letter : word) text += letter == '"' ? "\"\"" : std::string(1, letter);
    return text + "\"";
}

}  // namespace

void Table::add(std::vector<Cell> row) {
    row.resize(columns.size());
    rows.push_back(std::move(row));
}

void Table::append(const Table& other) {
    std::vector<size_t> places;
    for (const std::string& name : other.columns) {
        const auto found = std::find(columns.begin(), columns.end(), name);
        places.push_back(size_t(found - columns.begin()));
        if (found != columns.end()) continue;
        columns.push_back(name);
        for (auto& row : rows) row.emplace_back();
    }
    for (const auto& from : other.rows) {
        std::vector<Cell> row(columns.size());
        for (size_t c = 0; c < from.size(); ++c) row[places[c]] = from[c];
        rows.push_back(std::move(row));
    }
}

const Table::Cell* Table::find(size_t row, std::string_view column) const {
    for (size_t c = 0; c < columns.size(); ++c)
        if (columns[c] == column && row < rows.size()) return &rows[row][c];
    return nullptr;
}

std::string Table::text() const {
    const std::string rows_text = aligned(*this, "", "  ", "", false);
    return title.empty() ? rows_text : fmt::format("{}\n{}", title, rows_text);
}

std::string Table::markdown() const {
    const std::string rows_text = aligned(*this, "| ", " | ", " |", true);
    return title.empty() ? rows_text : fmt::format("### {}\n\n{}", title, rows_text);
}

std::string Table::csv() const {
    std::string text;
    for (size_t c = 0; c < columns.size(); ++c)
        text += fmt::format("{}{}", c ? "," : "", quoted(columns[c]));
    text += "\n";
    for (const auto& row : rows) {
        for (size_t c = 0; c < row.size(); ++c)
            text += fmt::format("{}{}", c ? "," : "", quoted(full_form(row[c])));
        text += "\n";
    }
    return text;
}

Json Table::json() const {
    Json list = Json::list();
    for (const auto& row : rows) {
        Json object = Json::object();
        for (size_t c = 0; c < row.size(); ++c) {
            const double* number = std::get_if<double>(&row[c]);
            if (number && std::isfinite(*number))
                object.set(columns[c], *number);
            else
                object.set(columns[c], full_form(row[c]));
        }
        list.items.push_back(std::move(object));
    }
    return list;
}

std::string table_as(const Table& table, std::string_view path) {
    if (path.ends_with(".md")) return table.markdown();
    if (path.ends_with(".csv")) return table.csv();
    if (path.ends_with(".json")) return table.json().dump(true) + "\n";
    return table.text();
}

size_t Table::bytes() const {
    size_t sum = sizeof *this;
    for (const auto& row : rows) sum += row.size() * sizeof(Cell);
    return sum;
}

}  // namespace weft
