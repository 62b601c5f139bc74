// Reading JSON: every value and key knows its place; all that is wrong is said where it is wrong.
#include "graph/json.h"

#include <gtest/gtest.h>

#include "graph/diagnostic.h"
#include "graph/error.h"

namespace weft {
namespace {

struct Parsed {
    SourcePtr source;
    Json json;
    std::vector<Diagnostic> findings;
};

Parsed parse(std::string text) {
    Parsed p;
    p.source = std::make_shared<const Source>(Source{"t.json", std::move(text)});
    p.json = parse_json(p.source, p.findings);
    return p;
}

std::string at(const Place& place) {
    return place.source->text.substr(place.begin, place.end - place.begin);
}

std::string first_finding(const std::string& text) {
    const Parsed p = parse(text);
    return p.findings.empty() ? "" : where(p.findings[0].place) + " " + p.findings[0].message;
}

TEST(json, every_value_and_key_has_the_span_of_its_token) {
    const Parsed p = parse(R"(  // a comment, with "quotes" : {
{"name" /* here */ : "a\tb", "list" : [1, -2.5e3 ,true,false, null , [ ] ], "o": { "x" : {} } }
)");
    ASSERT_TRUE(p.findings.empty()) << p.findings[0].message;
    EXPECT_EQ(at(p.json.members[0].key_place), "\"name\"");
    EXPECT_EQ(at(p.json.find("name")->place), "\"a\\tb\"");
    EXPECT_EQ(p.json.find("name")->text, "a\tb");
    const Json& list = *p.json.find("list");
    EXPECT_EQ(at(list.place), "[1, -2.5e3 ,true,false, null , [ ] ]");
    const std::vector<std::string> tokens{"1", "-2.5e3", "true", "false", "null", "[ ]"};
    ASSERT_EQ(list.items.size(), tokens.size());
    for (size_t i = 0; i < tokens.size(); ++i) EXPECT_EQ(at(list.items[i].place), tokens[i]);
    EXPECT_EQ(at(p.json.find("o")->place), "{ \"x\" : {} }");
    EXPECT_EQ(at(p.json.find("o")->members[0].key_place), "\"x\"");
    EXPECT_EQ(at(p.json.find("o")->find("x")->place), "{}");
    EXPECT_EQ(line_column(p.json.place).line, 2);
    EXPECT_EQ(line_column(p.json.place).column, 1);
}

TEST(json, columns_count_characters_not_bytes) {
    const Parsed p = parse("{\"größe\": 1}");
    EXPECT_EQ(line_column(p.json.find("größe")->place).column, 11);
}

TEST(json, a_byte_order_mark_is_skipped) {
    const Parsed p = parse("\xEF\xBB\xBF[7]");
    ASSERT_TRUE(p.findings.empty());
    EXPECT_EQ(at(p.json.items[0].place), "7");
}

TEST(json, numbers_keep_their_bits) {
    const Parsed p = parse(
        "[18446744073709551615, -9223372036854775808, 0.1, 1e300, 2.0, -0.0, 9007199254740993]");
    ASSERT_EQ(p.json.items.size(), 7u);
    EXPECT_TRUE(p.json.items[0].is_unsigned);
    EXPECT_EQ(std::uint64_t(p.json.items[0].integer), UINT64_MAX);
    EXPECT_EQ(p.json.items[1].integer, INT64_MIN);
    EXPECT_FALSE(p.json.items[2].is_integer);
    EXPECT_TRUE(p.json.items[4].is_integer);
    EXPECT_FALSE(p.json.items[5].is_integer);
    EXPECT_EQ(p.json.items[6].integer, 9007199254740993);
    EXPECT_EQ(
        p.json.dump(),
        "[18446744073709551615, -9223372036854775808, 0.1, 1e+300, 2, -0.0, 9007199254740993]");
    EXPECT_EQ(parse(p.json.dump()).json, p.json);
}

TEST(json, numbers_are_the_nearest_doubles) {
    const Parsed p = parse("[0e100, 8.41e21, 4.35, 2.2250738585072011e-308, 1e-999, 1.7976931348623157e308]");
    ASSERT_EQ(p.json.items.size(), 6u);
    EXPECT_EQ(p.json.items[0].number, 0);
    EXPECT_EQ(p.json.items[1].number, 8.41e21);
    EXPECT_EQ(p.json.items[2].number, 4.35);
    EXPECT_EQ(p.json.items[3].number, 2.2250738585072011e-308);
    EXPECT_EQ(p.json.items[4].number, 0);
    EXPECT_EQ(p.json.items[5].number, 1.7976931348623157e308);
}

TEST(json, dump_reads_back_equal_on_one_line_and_indented) {
    const Parsed p =
        parse(R"({"a": "quote \" back \\ bell \u0007 ü", "b": [[1, 2], {"c": {}}], "d": []})");
    EXPECT_EQ(parse(p.json.dump()).json, p.json);
    EXPECT_EQ(parse(p.json.dump(true)).json, p.json);
    EXPECT_EQ(p.json.dump().find('\n'), std::string::npos);
    Json o = Json::object();
    o.set("x", Json::list({1, 2.5, "t"}));
    o.set("y", Json::object()).set("z", true);
    EXPECT_EQ(o.dump(true), "{\n  \"x\": [1, 2.5, \"t\"],\n  \"y\": {\n    \"z\": true\n  }\n}");
}

TEST(json, objects_are_equal_in_any_order) {
    EXPECT_EQ(parse("{\"a\": 1, \"b\": [2]}").json, parse("{\"b\": [2.0], \"a\": 1}").json);
    EXPECT_FALSE(parse("{\"a\": 1}").json == parse("{\"a\": \"1\"}").json);
}

TEST(json, set_replaces_a_value_and_returns_it) {
    Json o = Json::object();
    o.set("a", 1);
    EXPECT_EQ(o.set("a", 2).integer, 2);
    EXPECT_EQ(o.members.size(), 1u);
}

TEST(json, a_key_that_is_there_twice_is_found_at_the_second) {
    const Parsed p = parse("{\"a\": 1,\n \"b\": {\"c\": 1, \"c\": 2},\n \"a\": 3}");
    ASSERT_EQ(p.findings.size(), 2u);
    EXPECT_EQ(where(p.findings[0].place), "t.json:2:16");
    EXPECT_EQ(where(p.findings[1].place), "t.json:3:2");
    EXPECT_EQ(p.findings[1].message,
              "'a' is here twice; it is first on line 1, remove one of them");
    EXPECT_EQ(p.json.find("a")->integer, 1);
}

TEST(json, syntax_errors_say_where_and_what_was_expected) {
    EXPECT_EQ(first_finding("{\"a\": 1 \"b\": 2}"), "t.json:1:9 expected ',' or '}'");
    EXPECT_EQ(first_finding("[1 2]"), "t.json:1:4 expected ',' or ']'");
    EXPECT_EQ(first_finding("{\"a\" 1}"), "t.json:1:6 expected ':' after the name");
    EXPECT_EQ(first_finding("{\"a\": 1,}"), "t.json:1:9 a ',' stands before this '}'; remove it");
    EXPECT_EQ(first_finding("[1,]"), "t.json:1:4 a ',' stands before this ']'; remove it");
    EXPECT_EQ(first_finding("{a: 1}"), "t.json:1:2 expected a name in double quotes");
    EXPECT_EQ(first_finding("[1] x"), "t.json:1:5 nothing may follow the end of the document");
    EXPECT_EQ(first_finding("{\"a\": \"b\nc\"}"),
              "t.json:1:7 this text is not closed before the end of the line; expected '\"'");
    EXPECT_EQ(first_finding("{\"a\": \"b"), "t.json:1:7 this text is not closed; expected '\"'");
    EXPECT_EQ(first_finding("{\n  \"a\": [1,\n"),
              "t.json:2:9 the text ends here, but the '[' of line 2 is not closed; expected ']'");
    EXPECT_EQ(first_finding("[1e999]"), "t.json:1:2 this number is too large");
    EXPECT_EQ(
        first_finding("[nope]"),
        "t.json:1:2 expected a value: \"text\", number, true, false, null, [list] or {object}");
    EXPECT_EQ(first_finding("[/* x"),
              "t.json:1:1 the text ends here, but the '[' of line 1 is not closed; expected ']'");
    EXPECT_EQ(first_finding(std::string("[1]\0", 4)),
              "t.json:1:4 nothing may follow the end of the document");
    EXPECT_EQ(first_finding("[\"\xff\"]"),
              "t.json:1:2 these bytes are no UTF-8 text (control characters are written as \\n, "
              "\\u0001)");
    EXPECT_EQ(first_finding("[\"a\\q\"]"),
              "t.json:1:4 unknown escape; known: \\\" \\\\ \\/ \\b \\f \\n \\r \\t \\uXXXX");
    EXPECT_NE(first_finding("   "), "");
}

TEST(json, what_could_be_read_before_an_error_is_returned) {
    const Parsed p = parse("{\"a\": [1, 2, oops]}");
    ASSERT_EQ(p.findings.size(), 1u);
    ASSERT_NE(p.json.find("a"), nullptr);
    EXPECT_EQ(p.json.find("a")->items.size(), 2u);
}

TEST(json, nesting_ends_at_a_hundred_levels) {
    EXPECT_TRUE(parse(std::string(100, '[') + std::string(100, ']')).findings.empty());
    EXPECT_EQ(first_finding(std::string(101, '[') + std::string(101, ']')),
              "t.json:1:101 nested deeper than 100 levels");
    EXPECT_FALSE(parse(std::string(1000000, '[')).findings.empty());
}

TEST(json, text_of_a_program_throws_with_its_name) {
    EXPECT_EQ(parse_json_or_throw("{\"a\": 1}", "lens.npz").find("a")->integer, 1);
    try {
        parse_json_or_throw("{\"a\": ", "lens.npz: meta");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find("lens.npz: meta: damaged JSON at line 1"), 0u);
    }
}

}  // namespace
}  // namespace weft
