#include "sextant/files/csv_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/text_files.hpp"

namespace sextant {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

TEST(CsvTable, ReadsNumbersByColumnAndKnowsTheirLines) {
  const TextFiles files;
  const CsvTable t = read_csv(
      files.write("t.csv", "# where it is from\n\n time_s , value\r\n0,1.5\n\n 2e0 , -3 # a step\n"));
  EXPECT_THAT(t.columns, ElementsAre("time_s", "value"));
  EXPECT_THAT(t.rows, ElementsAre(ElementsAre(0, 1.5), ElementsAre(2, -3)));
  EXPECT_THAT(t.lines, ElementsAre(4, 6));
  EXPECT_EQ(t.heading_line, 3);
  EXPECT_EQ(t.column("value"), 1U);
  EXPECT_EQ(t.place(1), files.path("t.csv") + ":6");
  EXPECT_EQ(refusal([&t] { (void)t.column("speed"); }),
            files.path("t.csv") + ":3: expected a column speed, found time_s,value");
}

// A byte order mark, quotes, line ends of three systems, and none at the end of the file.
TEST(CsvTable, ReadsWhatOtherProgramsWrite) {
  const TextFiles files;
  for (const char* text : {"\xef\xbb\xbf"
                           "a,b\r\n0,1\r\n2,3\r\n",
                           "a,b\r0,1\r2,3\r", "a,b\n0,1\n2,3", "\"a\",\"b\"\n\"0\",\"1\"\n\"2\", 3\n",
                           "\xef\xbb\xbf"
                           "# by\r\"a\",b\r0,1 # \"\r\r2,3"}) {
    const CsvTable t = read_csv(files.write("t.csv", text));
    EXPECT_THAT(t.columns, ElementsAre("a", "b")) << text;
    EXPECT_THAT(t.rows, ElementsAre(ElementsAre(0, 1), ElementsAre(2, 3))) << text;
  }
  const CsvTable quoted = read_csv(files.write("t.csv", "\"a, \"\"b\"\" #1\",c\n0,1\n"));
  EXPECT_THAT(quoted.columns, ElementsAre("a, \"b\" #1", "c"));
}

TEST(CsvTable, ReadsAPlusSignAndNoSecondSign) {
  const TextFiles files;
  EXPECT_THAT(read_csv(files.write("t.csv", "a\n+1.5\n-1\n+.5e+1\n")).rows,
              ElementsAre(ElementsAre(1.5), ElementsAre(-1), ElementsAre(5)));
  for (const char* cell : {"+", "+-1", "-+1", "++1"}) {
    const std::string file = files.write("t.csv", std::string{"a\n"} + cell + "\n");
    EXPECT_EQ(refusal([&file] { (void)read_csv(file); }),
              file + ":2: a must be a finite number, not \"" + cell + "\"");
  }
}

TEST(CsvTable, RefusesBytesThatNoTextHas) {
  const TextFiles files;
  const std::string nul(1, '\0');
  const struct {
    std::string text;
    const char* says;
  } cases[] = {
      {"a" + nul + ",b\n0,1\n", ":1: the byte 0x00 is no text"},
      {"a,b\n# " + nul + "\n0,1\n", ":2: the byte 0x00 is no text"},
      {"a,b\n0,1\x1b[31m\n", ":2: the byte 0x1b is no text"},
      {"a,b\r0,1\r\x7f\r", ":3: the byte 0x7f is no text"},
  };
  for (const auto& [text, says] : cases) {
    const std::string file = files.write("t.csv", text);
    EXPECT_EQ(refusal([&file] { (void)read_csv(file); }),
              file + says + "; save the file as text in UTF-8, or remove that byte");
  }
}

TEST(CsvTable, RefusesColumnsThatNobodyReads) {
  const TextFiles files;
  const CsvTable t = read_csv(files.write("t.csv", "a,b,grade\n0,1,2\n"));
  EXPECT_EQ(refusal([&t] { t.expect_only({"a", "b"}); }),
            files.path("t.csv") + ":1: unknown column grade; known are a,b");
  t.expect_only({"grade", "b", "a"});
}

TEST(CsvTable, RefusesWhatIsNoTableWithFileAndLine) {
  const TextFiles files;
  const struct {
    const char* text;
    const char* says;
  } cases[] = {
      {"", " is empty: expected a heading and at least one row"},
      {"# nothing\n", " is empty: expected a heading and at least one row"},
      {"a,b\n", " is empty: expected a heading and at least one row"},
      {"a,b\n0,1\n0,fast\n", ":3: b must be a finite number, not \"fast\""},
      {"a,b\n0,nan\n", ":2: b must be a finite number, not \"nan\""},
      {"a,b\n-inf,0\n", ":2: a must be a finite number, not \"-inf\""},
      {"a,b\n1e999,0\n", ":2: a must be a finite number, not \"1e999\""},
      {"a,b\n0,1 2\n", ":2: b must be a finite number, not \"1 2\""},
      {"a,b\n0,\n", ":2: b must be a finite number, not \"\""},
      {"a,b\n0\n", ":2: expected 2 values (a,b), found 1"},
      {"a,b\n0,1,2\n", ":2: expected 2 values (a,b), found 3"},
      {"0,1\n1,2\n", ":1: expected a heading with the names of the columns, found \"0,1\""},
      {"a,\n1,2\n", ":1: expected a heading with the names of the columns, found \"a,\""},
      {",a,b\n0,1,2\n",
       ":1: the first column has no name: name it or leave it out (of pandas: to_csv(index=False))"},
      {"a;b\n0;1\n",
       ":1: semicolons separate the columns: separate them by commas, and write numbers with points"},
      {"a\tb\n0\t1\n",
       ":1: tabs separate the columns: separate them by commas, and write numbers with points"},
      {"a,b,a\n1,2,3\n", ":1: the column a occurs twice"},
  };
  for (const auto& [text, says] : cases) {
    const std::string file = files.write("t.csv", text);
    EXPECT_EQ(refusal([&file] { (void)read_csv(file); }), file + says);
  }
  EXPECT_EQ(refusal([&files] { (void)read_csv(files.path("no.csv")); }),
            files.path("no.csv") + " cannot be read: No such file or directory");
  EXPECT_THAT(refusal([&files] { (void)read_csv(files.path("")); }), EndsWith("it is a directory"));
  EXPECT_THAT(refusal([] { (void)read_csv("/dev/zero"); }), HasSubstr("it is a device"));
  const std::string file = files.write("t.csv", "a,b\n0,1 #" + std::string(5000, 'x'));
  EXPECT_THAT(refusal([&file] { (void)read_csv(file); }), StartsWith(file + ":2: the line is longer than"));
}

}  // namespace
}  // namespace sextant
