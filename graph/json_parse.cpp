// Reading JSON: RapidJSON's reader drives; the tree, the places and the words for errors are ours.
#include <fmt/format.h>
#include <rapidjson/reader.h>

#include <algorithm>
#include <charconv>
#include <cctype>
#include <string>
#include <unordered_set>
#include <utility>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "graph/json.h"

namespace weft {
namespace {

// An input of RapidJSON's that says truly where it is: its own string stream may be copied into a
// parsing function, and then stands still until that returns.
class TextStream {
  public:
    using Ch = char;
    explicit TextStream(std::string_view text, size_t at = 0) : text_(text), at_(at) {}
    Ch Peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    Ch Take() { return at_ < text_.size() ? text_[at_++] : '\0'; }
    size_t Tell() const { return at_; }
    // Writing in place is not asked of this stream.
    Ch* PutBegin() { return nullptr; }
    void Put(Ch) {}
    void Flush() {}
    size_t PutEnd(Ch*) { return 0; }

  private:
    std::string_view text_;
    size_t at_;
};

constexpr size_t deepest = 100;

class TreeBuilder {
  public:
    TreeBuilder(const SourcePtr& source, const TextStream& stream, size_t begin,
                std::vector<Diagnostic>& findings)
        : source_(source), stream_(stream), findings_(findings), end_of_last_(begin) {}

    bool Null() { return add(Json(), stream_.Tell()); }
    bool Bool(bool v) { return add(Json(v), stream_.Tell()); }
    bool Int(int v) { return add(Json(std::int64_t(v)), stream_.Tell()); }
    bool Uint(unsigned v) { return add(Json(std::uint64_t(v)), stream_.Tell()); }
    bool Int64(std::int64_t v) { return add(Json(v), stream_.Tell()); }
    bool Uint64(std::uint64_t v) { return add(Json(v), stream_.Tell()); }
    // RapidJSON's value is nearly right: its exact way shifts by an undefined number on 0e100.
    bool Double(double v) {
        const size_t begin = next_token(), end = stream_.Tell();
        std::from_chars(source_->text.data() + begin, source_->text.data() + end, v);
        return add(Json(v), end);
    }
    bool RawNumber(const char*, rapidjson::SizeType, bool) { return false; }
    bool String(const char* s, rapidjson::SizeType n, bool) {
        return add(Json(std::string(s, n)), stream_.Tell());
    }
    bool Key(const char* s, rapidjson::SizeType n, bool) {
        const size_t begin = next_token();
        end_of_last_ = stream_.Tell();
        open_.back().key = std::string(s, n);
        open_.back().key_place = place(begin, end_of_last_);
        return true;
    }
    bool StartObject() { return open(Json::object()); }
    bool StartArray() { return open(Json::list()); }
    bool EndObject(rapidjson::SizeType) { return close(); }
    bool EndArray(rapidjson::SizeType) { return close(); }

    bool too_deep() const { return too_deep_; }
    // Where the token after the last one read starts.
    size_t next_token() const {
        const std::string& text = source_->text;
        size_t i = end_of_last_;
        while (i < text.size()) {
            if (std::string_view(" \t\r\n,:").find(text[i]) != std::string_view::npos) {
                ++i;
            } else if (text.compare(i, 2, "//") == 0) {
                i = std::min(text.find('\n', i), text.size());
            } else if (text.compare(i, 2, "/*") == 0) {
                const size_t stop = text.find("*/", i + 2);
                i = stop == std::string::npos ? text.size() : stop + 2;
            } else {
                break;
            }
        }
        return i;
    }
    size_t end_of_last() const { return end_of_last_; }
    const Json* innermost() const { return open_.empty() ? nullptr : &open_.back().value; }
    Json take() {
        while (!open_.empty()) fold();
        return std::move(root_);
    }
    Place place(size_t begin, size_t end) const {
        return {source_, std::uint32_t(begin), std::uint32_t(end)};
    }

  private:
    struct Frame {
        Json value;
        std::string key;
        Place key_place;
        std::unordered_set<std::string> keys;
    };

    bool add(Json value, size_t end) {
        value.place = place(next_token(), end);
        end_of_last_ = end;
        attach(std::move(value));
        return true;
    }
    bool open(Json value) {
        const size_t begin = next_token();
        end_of_last_ = begin + 1;
        value.place = place(begin, begin + 1);
        if (open_.size() == deepest) {
            too_deep_ = true;
            return false;
        }
        open_.push_back({std::move(value), {}, {}, {}});
        return true;
    }
    bool close() {
        end_of_last_ = next_token() + 1;
        fold();
        return true;
    }
    void fold() {
        Json value = std::move(open_.back().value);
        open_.pop_back();
        value.place.end = std::uint32_t(end_of_last_);
        attach(std::move(value));
    }
    void attach(Json value) {
        if (open_.empty()) {
            root_ = std::move(value);
            return;
        }
        Frame& frame = open_.back();
        if (frame.value.is(Json::Kind::list)) {
            frame.value.items.push_back(std::move(value));
        } else if (frame.keys.insert(frame.key).second) {
            frame.value.members.push_back(
                {std::move(frame.key), std::move(frame.key_place), std::move(value)});
        } else {
            const auto first =
                std::find_if(frame.value.members.begin(), frame.value.members.end(),
                             [&](const JsonMember& member) { return member.key == frame.key; });
            findings_.push_back(
                {Diagnostic::Level::error,
                 fmt::format("'{}' is here twice; it is first on line {}, remove one of them",
                             frame.key, line_column(first->key_place).line),
                 frame.key_place});
        }
    }

    const SourcePtr& source_;
    const TextStream& stream_;
    std::vector<Diagnostic>& findings_;
    std::vector<Frame> open_;
    Json root_;
    size_t end_of_last_;
    bool too_deep_ = false;
};

// The token at `begin`, for underlining.
size_t token_end(std::string_view text, size_t begin) {
    const auto is_word = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '+' || c == '.' ||
               c == '_' || (static_cast<unsigned char>(c) & 0x80);
    };
    size_t end = begin;
    if (end < text.size() && text[end] == '"') {
        for (++end; end < text.size() && text[end] != '"' && text[end] != '\n'; ++end)
            if (text[end] == '\\') ++end;
        return std::min(end < text.size() && text[end] == '"' ? end + 1 : end, text.size());
    }
    while (end < text.size() && is_word(text[end])) ++end;
    return std::min(std::max(end, begin + 1), std::max(text.size(), begin));
}

Diagnostic syntax_error(const SourcePtr& source, const TreeBuilder& tree,
                        rapidjson::ParseErrorCode code, size_t offset) {
    const std::string& text = source->text;
    const auto at = [&](std::string message, size_t begin, size_t end) {
        return Diagnostic{Diagnostic::Level::error, std::move(message), tree.place(begin, end)};
    };
    const size_t token = tree.next_token();  // the one being read
    if (tree.too_deep())
        return at(fmt::format("nested deeper than {} levels", deepest), token - 1, token);
    if (offset >= text.size() && code != rapidjson::kParseErrorDocumentEmpty &&
        code != rapidjson::kParseErrorStringMissQuotationMark) {
        if (const Json* open = tree.innermost()) {
            const bool list = open->is(Json::Kind::list);
            return at(
                fmt::format("the text ends here, but the '{}' of line {} is not closed; "
                            "expected '{}'",
                            list ? '[' : '{', line_column(open->place).line, list ? ']' : '}'),
                tree.end_of_last() - 1, tree.end_of_last());
        }
    }
    std::string message;
    size_t begin = offset;
    switch (code) {
        case rapidjson::kParseErrorDocumentEmpty:
            return at("the text is empty; expected an object: {\"weft\": 1, \"nodes\": {}}",
                      std::min(token, text.size()), std::min(token, text.size()));
        case rapidjson::kParseErrorDocumentRootNotSingular:
            message = "nothing may follow the end of the document";
            break;
        case rapidjson::kParseErrorObjectMissName:
            message = offset < text.size() && text[offset] == '}'
                          ? "a ',' stands before this '}'; remove it"
                          : "expected a name in double quotes";
            break;
        case rapidjson::kParseErrorObjectMissColon:
            message = "expected ':' after the name";
            break;
        case rapidjson::kParseErrorObjectMissCommaOrCurlyBracket:
            message = "expected ',' or '}'";
            break;
        case rapidjson::kParseErrorArrayMissCommaOrSquareBracket:
            message = "expected ',' or ']'";
            break;
        case rapidjson::kParseErrorStringUnicodeEscapeInvalidHex:
            message = "\\u needs four hexadecimal digits";
            break;
        case rapidjson::kParseErrorStringUnicodeSurrogateInvalid:
            message = "\\u names half a character; the other half must follow";
            break;
        case rapidjson::kParseErrorStringMissQuotationMark:
            message = "this text is not closed; expected '\"'";
            begin = token;
            break;
        case rapidjson::kParseErrorStringEscapeInvalid:
        case rapidjson::kParseErrorStringInvalidEncoding: {
            // Either may stand for a control character: mostly the end of a line.
            const size_t line_end = std::min(text.find('\n', token), text.size());
            if (token_end(text, token) == line_end && text[line_end - 1] != '"')
                return at("this text is not closed before the end of the line; expected '\"'",
                          token, line_end);
            if (code == rapidjson::kParseErrorStringEscapeInvalid && text[offset] == '\\') {
                message = "unknown escape; known: \\\" \\\\ \\/ \\b \\f \\n \\r \\t \\uXXXX";
                return at(message, offset, std::min(offset + 2, text.size()));
            }
            return at(
                "these bytes are no UTF-8 text (control characters are written as \\n, \\u0001)",
                token, token_end(text, token));
        }
        case rapidjson::kParseErrorNumberTooBig:
            message = "this number is too large";
            begin = token;
            break;
        case rapidjson::kParseErrorNumberMissFraction:
            message = "expected a digit after '.'";
            begin = token;
            break;
        case rapidjson::kParseErrorNumberMissExponent:
            message = "expected a digit in the exponent";
            begin = token;
            break;
        case rapidjson::kParseErrorUnspecificSyntaxError:
            message = "this comment is not closed";
            break;
        default:
            message = offset < text.size() && text[offset] == ']'
                          ? "a ',' stands before this ']'; remove it"
                          : "expected a value: \"text\", number, true, false, null, [list] or "
                            "{object}";
            if (token <= offset) begin = token;
    }
    begin = std::min(begin, text.size());
    return at(message, begin, token_end(text, begin));
}

}  // namespace

Json parse_json(const SourcePtr& source, std::vector<Diagnostic>& findings, bool* whole) {
    const std::string& text = source->text;
    if (whole) *whole = false;
    if (text.size() > UINT32_MAX - 1) {
        findings.push_back({Diagnostic::Level::error, "the text is larger than 4 GB", {source}});
        return {};
    }
    const size_t start = text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;  // a byte order mark
    TextStream stream(text, start);
    TreeBuilder tree(source, stream, start, findings);
    rapidjson::Reader reader;
    constexpr unsigned flags = rapidjson::kParseCommentsFlag | rapidjson::kParseIterativeFlag |
                               rapidjson::kParseValidateEncodingFlag;
    const rapidjson::ParseResult result = reader.Parse<flags>(stream, tree);
    if (result.IsError()) {
        findings.push_back(syntax_error(source, tree, result.Code(), result.Offset()));
    } else if (stream.Tell() < text.size()) {  // a zero byte looks like the end
        findings.push_back(syntax_error(source, tree, rapidjson::kParseErrorDocumentRootNotSingular,
                                        stream.Tell()));
    } else if (whole) {
        *whole = true;
    }
    return tree.take();
}

Json parse_json_or_throw(std::string_view text, const std::string& what) {
    std::vector<Diagnostic> findings;
    const auto source = std::make_shared<const Source>(Source{what, std::string(text)});
    Json json = parse_json(source, findings);
    if (!findings.empty()) {
        const LineColumn at = line_column(findings.front().place);
        throw Error(fmt::format("{}: damaged JSON at line {}, column {}: {}", what, at.line,
                                at.column, findings.front().message));
    }
    return json;
}

}  // namespace weft
