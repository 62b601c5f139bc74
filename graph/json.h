// Json: a document's values with the place each was written at.
// Source: own tree over RapidJSON's reader; comments (// and /* */) are allowed on reading.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace weft {

// The text a value came from: a file, or an option of the command line ("--set locations=64").
struct Source {
    std::string name;
    std::string text;
};
using SourcePtr = std::shared_ptr<const Source>;

struct Diagnostic;

// A span of a source's text, in bytes.
struct Place {
    SourcePtr source;
    std::uint32_t begin = 0, end = 0;
};

struct JsonMember;

class Json {
  public:
    enum class Kind { null, boolean, number, text, list, object };

    Json() = default;
    Json(bool value);
    Json(double value);         // a whole number within 2^53 is an integer too
    Json(std::int64_t value);
    Json(std::uint64_t value);
    Json(int value);
    Json(std::string value);
    Json(std::string_view value);
    Json(const char* value);
    static Json list(std::vector<Json> items);
    static Json list();
    static Json object();

    bool is(Kind k) const { return kind == k; }
    const Json* find(std::string_view key) const;   // member of an object, or nullptr
    Json* find(std::string_view key);
    Json& set(std::string_view key, Json value);     // adds or replaces; returns the member's value

    // Text of the value: one line, or indented by two blanks a level. Numbers round-trip.
    std::string dump(bool indented = false) const;

    bool operator==(const Json& other) const;        // values only, not places

    Kind kind = Kind::null;
    bool boolean = false;
    bool is_integer = false;       // number without fraction or exponent that fits 64 bits
    bool is_unsigned = false;      // above the range of integer: `integer` holds its bits
    std::int64_t integer = 0;
    double number = 0;             // also set for integers
    std::string text;
    std::vector<Json> items;       // list
    std::vector<JsonMember> members;  // object, in document order
    Place place;                   // where it stands; source is null for values made in code
};

struct JsonMember {
    std::string key;
    Place key_place;
    Json value;
};

// Here, where JsonMember is complete.
inline Json::Json(bool value) : kind(Kind::boolean), boolean(value) {}
inline Json::Json(int value) : Json(std::int64_t{value}) {}
inline Json::Json(std::string value) : kind(Kind::text), text(std::move(value)) {}
inline Json::Json(std::string_view value) : Json(std::string(value)) {}
inline Json::Json(const char* value) : Json(std::string(value)) {}

// What a kind is called in messages: "a number", "a list" ...
std::string_view name_of(Json::Kind kind);

// Parses a whole text. Syntax errors, duplicate keys and nesting past 100 levels are added to
// `findings`; what could be read is returned all the same, null where nothing could.
// `whole`: set to whether the text was read to its end.
Json parse_json(const SourcePtr& source, std::vector<Diagnostic>& findings, bool* whole = nullptr);

// The same for text that a program wrote (a sample file's meta); throws Error naming `what`.
Json parse_json_or_throw(std::string_view text, const std::string& what);

}  // namespace weft
