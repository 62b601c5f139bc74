// Values against the parameters they are given to.
#include "graph/declaration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace weft {
namespace {

ParamDecl decl(Kind kind) {
    ParamDecl d;
    d.name = "p";
    d.kind = kind;
    return d;
}

TEST(declaration, each_kind_takes_its_own_values) {
    const Json color = Json::list({0.5, 1, 2}), list = Json::list({1, "a"}),
               object = Json::object();
    const std::vector<std::pair<Kind, std::vector<Json>>> fits{
        {Kind::number, {1, 2.5, -1e30}},
        {Kind::integer, {1, 2.0, std::uint64_t(1) << 63}},
        {Kind::boolean, {true}},
        {Kind::text, {"", "x"}},
        {Kind::file, {"x"}},
        {Kind::color, {color}},
        {Kind::list, {color, list}},
        {Kind::object, {object}},
    };
    const std::vector<Json> all{1, 2.5, true, "x", color, list, object, Json()};
    for (const auto& [kind, good] : fits) {
        for (const Json& value : good)
            EXPECT_EQ(mismatch(decl(kind), value), "") << name_of(kind) << value.dump();
        for (const Json& value : all) {
            const bool text =
                (kind == Kind::text || kind == Kind::file) && value.is(Json::Kind::text);
            const bool number = kind == Kind::number && value.is(Json::Kind::number);
            if (std::find(good.begin(), good.end(), value) == good.end() && !text && !number) {
                EXPECT_NE(mismatch(decl(kind), value), "") << name_of(kind) << value.dump();
            }
        }
    }
}

TEST(declaration, what_is_wrong_is_told_with_range_and_unit) {
    ParamDecl d = decl(Kind::number);
    d.name = "sigma-range";
    d.minimum = 1e-4;
    d.maximum = 1e3;
    d.unit = "guide";
    EXPECT_EQ(mismatch(d, -1), "sigma-range is -1; expected 1e-4 to 1e3 (guide)");
    EXPECT_EQ(mismatch(d, 1e-4), "");
    EXPECT_EQ(mismatch(d, 1e3), "");
    EXPECT_EQ(mismatch(d, "x"), "sigma-range is \"x\"; expected a number, 1e-4 to 1e3 (guide)");
    d.unit = "";
    d.maximum = std::numeric_limits<double>::infinity();
    d.minimum = 0.5;
    EXPECT_EQ(mismatch(d, 0), "sigma-range is 0; expected at least 0.5");
    d.minimum = -d.maximum;
    d.maximum = 128;
    EXPECT_EQ(mismatch(d, 129), "sigma-range is 129; expected at most 128");
    d.kind = Kind::integer;
    d.minimum = 1;
    d.maximum = 1000000;
    EXPECT_EQ(mismatch(d, 0), "sigma-range is 0; expected 1 to 1000000");
}

TEST(declaration, a_choice_lists_its_choices) {
    ParamDecl d = decl(Kind::choice);
    d.choices = {"box", "tent"};
    EXPECT_EQ(mismatch(d, "tent"), "");
    EXPECT_EQ(mismatch(d, "tend"), "p is \"tend\"; expected one of 'box', 'tent'");
    EXPECT_EQ(mismatch(d, 3), "p is 3; expected one of 'box', 'tent'");
}

TEST(declaration, an_empty_file_name_is_none_unless_allowed) {
    ParamDecl d = decl(Kind::file);
    EXPECT_EQ(mismatch(d, ""), "p is empty; expected a file name");
    d.optional_file = true;
    EXPECT_EQ(mismatch(d, ""), "");
    EXPECT_NE(mismatch(d, std::string("a\0b", 3)), "");
}

TEST(declaration, numbers_are_shown_as_they_were_written) {
    const auto source = std::make_shared<const Source>(Source{"t", "1.50e+2"});
    Json value = 150.0;
    value.place = {source, 0, 7};
    ParamDecl d = decl(Kind::number);
    d.maximum = 1;
    EXPECT_EQ(mismatch(d, value), "p is 1.50e+2; expected at most 1");
}

TEST(declaration, ports_and_parameters_are_found_by_name) {
    NodeDecl node;
    node.inputs = {{"a", "", "T"}, {"b", "", "T"}};
    node.outputs = {{"c", "", "T"}};
    node.params = {decl(Kind::text)};
    EXPECT_EQ(node.find_input("b"), 1);
    EXPECT_EQ(node.find_input("c"), -1);
    EXPECT_EQ(node.find_output("c"), 0);
    EXPECT_EQ(node.find_param("p"), &node.params[0]);
    EXPECT_EQ(node.find_param("q"), nullptr);
}

}  // namespace
}  // namespace weft
