// Tables: their forms.
#include "image/table.h"

#include <limits>

#include "image/picture_file.h"
#include "run_node.h"

namespace weft {
namespace {

Table sample() {
    Table table({"picture", "relmse", "note"});
    table.add({std::string("box"), 0.125, std::string("a, \"b\"")});
    table.add({std::string("tlfr"), std::numeric_limits<double>::infinity()});
    return table;
}

TEST(Table, TextIsAligned) {
    EXPECT_EQ(sample().text(),
              "picture  relmse  note\n"
              "box       0.125  a, \"b\"\n"
              "tlfr        inf\n");
}

TEST(Table, MarkdownHasARule) {
    Table table({"a", "b"});
    table.title = "T";
    table.add({std::string("x"), 1.5});
    EXPECT_EQ(table.markdown(),
              "### T\n\n"
              "| a   |   b |\n"
              "| --- | --: |\n"
              "| x   | 1.5 |\n");
}

TEST(Table, CsvQuotesAndKeepsAllDigits) {
    Table table = sample();
    table.rows[0][1] = 0.1 + 0.2;
    EXPECT_EQ(table.csv(),
              "picture,relmse,note\n"
              "box,0.30000000000000004,\"a, \"\"b\"\"\"\n"
              "tlfr,inf,\n");
}

TEST(Table, JsonIsAListOfObjects) {
    const Json json = sample().json();
    ASSERT_EQ(json.items.size(), 2u);
    EXPECT_EQ(json.items[0].find("relmse")->number, 0.125);
    EXPECT_EQ(json.items[1].find("relmse")->text, "inf");
}

TEST(Table, AppendJoinsByColumn) {
    Table a({"x", "y"}), b({"y", "z"});
    a.add({1.0, 2.0});
    b.add({3.0, 4.0});
    a.append(b);
    EXPECT_EQ(a.columns, (std::vector<std::string>{"x", "y", "z"}));
    EXPECT_EQ(std::get<double>(*a.find(1, "y")), 3.0);
    EXPECT_EQ(std::get<std::string>(*a.find(0, "z")), "");
}

TEST(WriteTable, ChoosesTheFormByExtension) {
    TestFolder folder;
    const Table table = sample();
    for (const auto& [name, text] : {std::pair{"t.md", table.markdown()},
                                     {"t.csv", table.csv()},
                                     {"t.json", table.json().dump(true) + "\n"},
                                     {"t.txt", table.text()}}) {
        RunNode("write-table").set("file", folder / name).in("table", table).run();
        EXPECT_EQ(read_whole_file(folder / name), text) << name;
    }
}

TEST(WriteTable, WritesToStandardOutput) {
    const Table table = sample();
    testing::internal::CaptureStdout();
    RunNode("write-table").in("table", table).run();
    EXPECT_EQ(testing::internal::GetCapturedStdout(), sample().text());
}

}  // namespace
}  // namespace weft
