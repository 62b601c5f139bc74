// What a finding looks like, and which name it suggests.
#include "graph/diagnostic.h"

#include <gtest/gtest.h>

namespace weft {
namespace {

Diagnostic finding(std::string text, std::uint32_t begin, std::uint32_t end) {
    const auto source = std::make_shared<const Source>(Source{"shade.json", std::move(text)});
    return {Diagnostic::Level::error, "it is wrong", {source, begin, end}};
}

TEST(diagnostic, the_line_is_shown_without_its_indentation_and_the_token_underlined) {
    EXPECT_EQ(to_text(finding("{\n\t  \"a\": 12,\n}", 10, 12)),
              "shade.json:2:9: error: it is wrong\n"
              "    \"a\": 12,\n"
              "         ^~");
}

TEST(diagnostic, a_long_line_is_cut_around_the_place) {
    const std::string text = std::string(300, 'x') + "HERE" + std::string(300, 'y');
    const std::string told = to_text(finding(text, 300, 304));
    EXPECT_NE(told.find("...xxx"), std::string::npos);
    EXPECT_NE(told.find("yyy..."), std::string::npos);
    const size_t line = told.find('\n') + 1, under = told.find('\n', line) + 1;
    EXPECT_LT(under - line, 120u);
    EXPECT_EQ(told.substr(line + told.find('^') - under, 4), "HERE");
    EXPECT_EQ(told.substr(told.find('^')), "^~~~");
}

TEST(diagnostic, characters_of_several_bytes_count_once) {
    EXPECT_EQ(to_text(finding("{\"größe\": \"süß\"}", 12, 19)),
              "shade.json:1:11: error: it is wrong\n"
              "    {\"größe\": \"süß\"}\n"
              "              ^~~~~");
}

TEST(diagnostic, a_place_at_or_past_the_end_is_no_harm) {
    EXPECT_NE(to_text(finding("abc", 3, 3)).find("^"), std::string::npos);
    EXPECT_NE(to_text(finding("abc\n", 4, 4)).find("^"), std::string::npos);
    EXPECT_NE(to_text(finding("abc", 90, 95)).find("^"), std::string::npos);
}

TEST(diagnostic, nothing_of_a_text_reaches_the_terminal_as_control) {
    EXPECT_EQ(to_text(finding("a\x1b[2Jb", 0, 1)).find('\x1b'), std::string::npos);
}

TEST(diagnostic, an_option_is_its_own_place) {
    const auto source = std::make_shared<const Source>(Source{"--set a=b", "--set a=b"});
    EXPECT_EQ(to_text({Diagnostic::Level::error, "no", {source, 6, 7}}), "--set a=b: error: no");
    EXPECT_EQ(where({source, 6, 7}), "--set a=b");
}

TEST(diagnostic, without_a_place_only_the_message_is_told) {
    EXPECT_EQ(to_text({Diagnostic::Level::warning, "hm", {}}), "warning: hm");
    EXPECT_EQ(where({}), "");
}

TEST(diagnostic, colours_only_when_asked_for) {
    const Diagnostic d = finding("abc", 0, 3);
    EXPECT_EQ(to_text(d).find('\x1b'), std::string::npos);
    EXPECT_NE(to_text(d, true).find("\x1b[1;31merror:"), std::string::npos);
}

TEST(diagnostic, only_a_name_close_enough_is_suggested) {
    const std::vector<std::string> known{"same-surface-cluster", "samples", "reproject", "in",
                                         "uv"};
    EXPECT_EQ(nearest_name("same-surface-clutser", known), "same-surface-cluster");
    EXPECT_EQ(nearest_name("Same_Surface_Cluster", known), "same-surface-cluster");
    EXPECT_EQ(nearest_name("sampels", known), "samples");
    EXPECT_EQ(nearest_name("im", known), "in");
    EXPECT_EQ(nearest_name("x", known), "");
    EXPECT_EQ(nearest_name("xy", known), "");
    EXPECT_EQ(nearest_name("denoise", known), "");
    EXPECT_EQ(nearest_name("", known), "");
    EXPECT_EQ(nearest_name(std::string(100000, 'a'), known), "");
}

TEST(diagnostic, with_no_near_name_the_known_ones_are_told) {
    EXPECT_EQ(suggestion("sampels", {"samples"}), "; did you mean 'samples'?");
    EXPECT_EQ(suggestion("zzz", {"a", "b"}), "; known: a, b");
    EXPECT_EQ(suggestion("zzz", {}), "");
    const std::vector<std::string> many(20, "name");
    EXPECT_EQ(suggestion("zzz", many).substr(suggestion("zzz", many).size() - 5), ", ...");
}

}  // namespace
}  // namespace weft
