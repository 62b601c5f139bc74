#include "graph/diagnostic.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace weft {
namespace {

bool continues_character(char c) {
    return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

int characters(std::string_view text) {
    return int(
        std::count_if(text.begin(), text.end(), [](char c) { return !continues_character(c); }));
}

// Options of the command line are their own text: there is no line to show.
bool is_option(const Place& place) {
    return place.source && place.source->name == place.source->text;
}

// One printable column a character.
std::string printable(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    return out;
}

// Steps `count` characters from `at`, forwards or backwards, within text.
size_t step(std::string_view text, size_t at, int count) {
    for (; count > 0 && at < text.size(); --count)
        for (++at; at < text.size() && continues_character(text[at]);) ++at;
    for (; count < 0 && at > 0; ++count)
        for (--at; at > 0 && continues_character(text[at]);) --at;
    return at;
}

// The line of `place`, cut to a window around it, and its underline.
std::string excerpt(const Place& place, std::string_view on, std::string_view off) {
    const std::string_view text = place.source->text;
    const size_t at = std::min<size_t>(place.begin, text.size());
    size_t begin = at ? text.rfind('\n', at - 1) : std::string_view::npos;
    begin = begin == std::string_view::npos ? 0 : begin + 1;
    const size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(begin, end - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    size_t first = std::min(at - begin, line.size());
    size_t last = std::clamp<size_t>(place.end - begin, first, line.size());

    const size_t indent = std::min(line.find_first_not_of(" \t"), first);
    line.remove_prefix(indent);
    first -= indent;
    last -= indent;

    constexpr int wide = 100;
    std::string_view before, after;
    if (characters(line) > wide) {
        const size_t from =
            characters(line.substr(0, first)) > wide / 2 ? step(line, first, -wide / 2) : 0;
        const size_t to = step(line, from, wide);
        if (from > 0) before = "...";
        if (to < line.size()) after = "...";
        line = line.substr(from, to - from);
        first -= from;
        last = std::min(last - from, line.size());
    }
    const int blanks = 4 + int(before.size()) + characters(line.substr(0, first));
    const int marks = std::max(1, characters(line.substr(first, last - first)));
    return fmt::format("\n    {}{}{}\n{}{}^{}{}", before, printable(line), after,
                       std::string(size_t(blanks), ' '), on, std::string(size_t(marks - 1), '~'),
                       off);
}

// Upper case and '_' are forgiven.
char plain(char c) {
    if (c == '_' || c == ' ') return '-';
    return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
}

// Edits (insert, remove, replace, swap neighbours) that turn one name into the other.
size_t edits(std::string_view a, std::string_view b) {
    std::vector<std::array<size_t, 3>> rows(b.size() +
                                            1);  // [j]{this row, last row, the one before}
    for (size_t j = 0; j <= b.size(); ++j) rows[j][0] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        for (auto& r : rows) r = {0, r[0], r[1]};
        rows[0][0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const bool same = plain(a[i - 1]) == plain(b[j - 1]);
            rows[j][0] = std::min({rows[j - 1][0] + 1, rows[j][1] + 1, rows[j - 1][1] + !same});
            if (i > 1 && j > 1 && plain(a[i - 1]) == plain(b[j - 2]) &&
                plain(a[i - 2]) == plain(b[j - 1]))
                rows[j][0] = std::min(rows[j][0], rows[j - 2][2] + 1);
        }
    }
    return rows[b.size()][0];
}

}  // namespace

LineColumn line_column(const Place& place) {
    LineColumn at;
    if (!place.source) return at;
    const std::string_view text = std::string_view(place.source->text).substr(0, place.begin);
    at.line = 1 + int(std::count(text.begin(), text.end(), '\n'));
    const size_t line = text.rfind('\n');
    at.column = 1 + characters(line == std::string_view::npos ? text : text.substr(line + 1));
    return at;
}

std::string where(const Place& place) {
    if (!place.source) return "";
    if (place.source->text.empty() || is_option(place)) return place.source->name;
    const LineColumn at = line_column(place);
    return fmt::format("{}:{}:{}", place.source->name, at.line, at.column);
}

std::string to_text(const Diagnostic& finding, bool color) {
    const bool error = finding.level == Diagnostic::Level::error;
    const std::string_view bold = color ? "\x1b[1m" : "";
    const std::string_view tint = !color ? "" : error ? "\x1b[1;31m" : "\x1b[1;35m";
    const std::string_view mark = color ? "\x1b[32m" : "";
    const std::string_view off = color ? "\x1b[0m" : "";
    std::string out;
    const std::string place = where(finding.place);
    if (!place.empty()) out += fmt::format("{}{}:{} ", bold, printable(place), off);
    out += fmt::format("{}{}:{} {}", tint, error ? "error" : "warning", off, finding.message);
    if (finding.place.source && !finding.place.source->text.empty() && !is_option(finding.place))
        out += excerpt(finding.place, mark, off);
    return out;
}

bool has_errors(const std::vector<Diagnostic>& findings) {
    return std::any_of(findings.begin(), findings.end(), [](const Diagnostic& finding) {
        return finding.level == Diagnostic::Level::error;
    });
}

std::string nearest_name(std::string_view wrong, const std::vector<std::string>& known) {
    constexpr size_t longest = 100;
    if (wrong.size() > longest) return "";
    std::string nearest;
    size_t least = longest;
    for (const std::string& name : known) {
        if (name.size() > longest) continue;
        // A third of the letters may be wrong, but never all of them.
        const size_t longer = std::max(name.size(), wrong.size());
        const size_t allowed = std::min((longer + 1) / 3, longer - 1);
        const size_t distance = longer ? edits(wrong, name) : longest;
        if (distance <= allowed && distance < least) {
            least = distance;
            nearest = name;
        }
    }
    return nearest;
}

std::string suggestion(std::string_view wrong, const std::vector<std::string>& known) {
    const std::string nearest = nearest_name(wrong, known);
    if (!nearest.empty()) return fmt::format("; did you mean '{}'?", nearest);
    if (known.empty()) return "";
    constexpr size_t most = 12;
    const auto last = known.begin() + std::ptrdiff_t(std::min(known.size(), most));
    return fmt::format("; known: {}{}", fmt::join(known.begin(), last, ", "),
                       known.size() > most ? ", ..." : "");
}

}  // namespace weft
