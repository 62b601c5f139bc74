// Diagnostic: one finding about a document, with its place.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "graph/json.h"

namespace weft {

struct Diagnostic {
    enum class Level { error, warning };
    Level level = Level::error;
    std::string message;  // "no node type 'bilateral-fliter'; did you mean 'bilateral-filter'?"
    Place place;          // source null: the finding is about no place in a text
};

// Line and column, both from 1; a column is a UTF-8 character.
struct LineColumn {
    int line = 1, column = 1;
};
LineColumn line_column(const Place& place);

// "file:line:col", or the source's name alone, or "".
std::string where(const Place& place);

// "file:line:col: error: message", the line itself, and the token underlined with ^~~~.
// `color`: ANSI colours for a terminal.
std::string to_text(const Diagnostic& finding, bool color = false);

bool has_errors(const std::vector<Diagnostic>& findings);

// The known name nearest to `wrong`, or "" if none is close enough to be meant.
std::string nearest_name(std::string_view wrong, const std::vector<std::string>& known);

// "; did you mean 'x'?" or, with no near name, "; known: a, b, c" (at most 12 names), or "".
std::string suggestion(std::string_view wrong, const std::vector<std::string>& known);

}  // namespace weft
