#include "sextant/virtual_time/candump_log.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sextant {
namespace {

using ::testing::HasSubstr;

bool same(const CanFrame& a, const CanFrame& b) {
  return a.id == b.id && a.extended == b.extended && a.rtr == b.rtr && a.error == b.error && a.fd == b.fd &&
         a.length == b.length && a.data == b.data;
}

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "no complaint";
}

class CandumpLogTest : public ::testing::Test {
 protected:
  CandumpLogTest() {
    std::string name = (std::filesystem::temp_directory_path() / "sextant-log-XXXXXX").string();
    directory = ::mkdtemp(name.data());
    file = (directory / "a.log").string();
  }
  ~CandumpLogTest() override { std::filesystem::remove_all(directory); }
  void write(const std::string& text) { std::ofstream{file} << text; }

  std::filesystem::path directory;
  std::string file;
};

TEST_F(CandumpLogTest, ReadsWhatCandumpAndPythonCanWrite) {
  write(
      "(1699999999.123456) can0 110#0C100000983A0000\n"
      "(1699999999.133456) vcan1 00000110#AB R\n"
      "\n"
      "(1699999999.2) can0 20000040#0000000000000000 T\r\n"
      "(1699999999.300000) can0 110#R\n"
      "(1699999999.300000) can0 7FF#R8\n"
      "(1699999999.400000001) can0 123##3AABBCC\n"
      "(1699999999.500000) can0 120#0102030405060708_9\n"
      "(1699999999.600000) can0 1FFFFFFF#\n"
      "(1699999999.700000) can0 7FF#R8_f\n");
  const std::vector<LoggedFrame> log = read_candump(file);
  ASSERT_EQ(log.size(), 9U);
  EXPECT_EQ(log[0].t_ns, 1'699'999'999'123'456'000);
  EXPECT_EQ(log[0].interface, "can0");
  EXPECT_TRUE(same(log[0].frame, {.id = 0x110, .length = 8, .data = {0x0C, 0x10, 0, 0, 0x98, 0x3A}}));
  EXPECT_EQ(log[1].interface, "vcan1");
  EXPECT_TRUE(same(log[1].frame, {.id = 0x110, .extended = true, .length = 1, .data = {0xAB}}));
  EXPECT_EQ(log[2].t_ns, 1'699'999'999'200'000'000);
  EXPECT_TRUE(same(log[2].frame, {.id = 0x40, .error = true, .length = 8}));
  EXPECT_TRUE(same(log[3].frame, {.id = 0x110, .rtr = true}));
  EXPECT_TRUE(same(log[4].frame, {.id = 0x7FF, .rtr = true, .length = 8}));
  EXPECT_EQ(log[5].t_ns, 1'699'999'999'400'000'001);
  EXPECT_TRUE(same(log[5].frame, {.id = 0x123, .fd = true, .length = 3, .data = {0xAA, 0xBB, 0xCC}}));
  EXPECT_TRUE(same(log[6].frame, {.id = 0x120, .length = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}}));
  EXPECT_TRUE(same(log[7].frame, {.id = 0x1FFFFFFF, .extended = true}));
  EXPECT_TRUE(same(log[8].frame, {.id = 0x7FF, .rtr = true, .length = 8}));
}

TEST_F(CandumpLogTest, EveryFrameReadsBackAsItWasWritten) {
  std::mt19937_64 dice{20};
  for (int n = 0; n < 2000; ++n) {
    LoggedFrame x{.t_ns = std::int64_t(dice() % 4'000'000'000'000'000ULL) * 1000, .interface = "vcan0"};
    CanFrame& f = x.frame;
    const auto kind = dice() % 5;
    f.extended = kind == 1;
    f.rtr = kind == 2;
    f.error = kind == 3;
    f.fd = kind == 4;
    f.id = std::uint32_t(dice()) & (f.extended || f.error ? 0x1FFFFFFFU : 0x7FFU);
    f.length = std::uint8_t(dice() % (f.fd ? 65 : 9));
    if (!f.rtr) {
      for (std::size_t k = 0; k < f.length; ++k) f.data[k] = std::uint8_t(dice());
    }
    const LoggedFrame back = parse_candump(format_candump(x));
    ASSERT_EQ(back.t_ns, x.t_ns) << format_candump(x);
    ASSERT_EQ(back.interface, x.interface);
    ASSERT_TRUE(same(back.frame, f)) << format_candump(x);
  }
}

TEST_F(CandumpLogTest, WritesAFileThatItReads) {
  CandumpWriter writer{file};
  writer.add({1'000'000'000, "can0", {.id = 0x110, .length = 2, .data = {1, 2}}});
  writer.add({1'500'001'999, "can0", {.id = 0x7, .length = 0}});
  writer.close();
  std::ifstream stream{file};
  const std::string text{std::istreambuf_iterator<char>{stream}, {}};
  EXPECT_EQ(text, "(0000000001.000000) can0 110#0102\n(0000000001.500001) can0 007#\n");
}

TEST_F(CandumpLogTest, NamesFileAndLineOfWhatItCannotRead) {
  const std::string good = "(1.000000) can0 110#00\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"1.0 can0 110#00", "expected a time"},
      {"(1) can0 110#00", "expected a time"},
      {"(1.) can0 110#00", "expected a time"},
      {"(1.0000000001) can0 110#00", "expected a time"},
      {"(-1.000000) can0 110#00", "expected a time"},
      {"(2.000000)", "name of an interface"},
      {"(2.000000) can0", "expected a frame"},
      {"(2.000000) can0 110", "expected a frame"},
      {"(2.000000) can0 11#00", "3 or 8 hexadecimal digits"},
      {"(2.000000) can0 XYZ#00", "3 or 8 hexadecimal digits"},
      {"(2.000000) can0 FFF#00", "more than 11 bits"},
      {"(2.000000) can0 8FFFFFFF#00", "more than 29 bits"},
      {"(2.000000) can0 110#0", "two hexadecimal digits"},
      {"(2.000000) can0 110#001122334455667788", "up to 8 bytes"},
      {"(2.000000) can0 110#0G", "no byte"},
      {"(2.000000) can0 110#R9", "length from 0 to 8"},
      {"(2.000000) can0 110##", "digit of flags"},
      {"(2.000000) can0 110#00_rubbish", "one digit from 9 to F"},
      {"(2.000000) can0 110#00_9", "behind eight bytes"},
      {"(2.000000) can0 110#0011223344556677_8", "one digit from 9 to F"},
      {"(2.000000) can0 110#0011223344556677_G", "one digit from 9 to F"},
      {"(2.000000) can0 110#0011223344556677_99", "one digit from 9 to F"},
      {"(2.000000) can0 110#0011223344556677_", "one digit from 9 to F"},
      {"(2.000000) can0 110#R_9", "behind eight bytes"},
      {"(2.000000) can0 123#81:00:12345678#11", "CAN XL"},
      {"(2.000000) can0 110#00 X", "nothing but R or T"},
      {"(2.000000) can0 110#00 R R", "nothing but R or T"},
      {"(0.500000) can0 110#00", "time goes back"},
      {"(86401.000001) can0 110#00", "jumps ahead by 86400.000001 s"},
      {"(8999999999.000000) can0 110#00", "a log may have gaps of 86400 s"},
      {"(2.000000) can0 110#" + std::string(4096, '0'), "longer than 4096 bytes"},
  };
  for (const auto& [line, complaint] : cases) {
    write(good + "\n" + line + "\n");
    const std::string message = message_of([&] { (void)read_candump(file); });
    EXPECT_THAT(message, HasSubstr(file + ":3: ")) << line;
    EXPECT_THAT(message, HasSubstr(complaint)) << line;
  }
}

TEST_F(CandumpLogTest, ADayOfSilenceIsRead) {
  write("(1.000000) can0 110#00\n(86401.000000) can0 110#00\n");
  EXPECT_EQ(read_candump(file).size(), 2U);
}

TEST_F(CandumpLogTest, RefusesFilesThatAreNone) {
  EXPECT_THAT(message_of([&] { (void)read_candump("/dev/zero"); }),
              HasSubstr("/dev/zero cannot be read: it is a device"));
  EXPECT_THAT(message_of([&] { (void)read_candump(file); }), HasSubstr("cannot be read: No such file"));
  EXPECT_THAT(message_of([&] { (void)read_candump(directory.string()); }), HasSubstr("is a directory"));
  // Its first byte is at address zero, where nothing can be read.
  EXPECT_THAT(message_of([&] { (void)read_candump("/proc/self/mem"); }),
              HasSubstr("/proc/self/mem cannot be read to its end"));
  write("\n");
  EXPECT_THAT(message_of([&] { (void)read_candump(file); }), HasSubstr("holds no frame"));
  EXPECT_THAT(message_of([&] { CandumpWriter{(directory / "no" / "a.log").string()}; }),
              HasSubstr("cannot be written: No such file"));
}

TEST_F(CandumpLogTest, TellsWhenTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  CandumpWriter writer{"/dev/full"};
  for (int n = 0; n < 1000; ++n) writer.add({n, "can0", {.id = 1}});
  EXPECT_THAT(message_of([&] { writer.close(); }), HasSubstr("/dev/full cannot be written"));
}

TEST_F(CandumpLogTest, OrdersTheFramesOfEachInterface) {
  write("(1.0) can0 110#00\n(1.2) can0 112#\n(1.1) can1 111#\n");
  const std::vector<LoggedFrame> log = read_candump(file);
  EXPECT_EQ(select_interface(log, "can0", file).size(), 2U);
  EXPECT_EQ(select_interface(log, "can1", file).size(), 1U);
  write("(1.0) can0 110#00\n(0.5) can1 111#\n(0.9) can0 112#\n");
  EXPECT_THAT(message_of([&] { (void)read_candump(file); }), HasSubstr("3: the time goes back"));
}

TEST_F(CandumpLogTest, SelectsAnInterface) {
  write("(1.0) can0 110#00\n(1.1) can1 111#\n(1.2) can0 112#\n");
  const std::vector<LoggedFrame> log = read_candump(file);
  EXPECT_EQ(select_interface(log, "can0", file).size(), 2U);
  EXPECT_EQ(select_interface(log, "can1", file).size(), 1U);
  EXPECT_THAT(message_of([&] { (void)select_interface(log, "", file); }), HasSubstr("can0, can1"));
  EXPECT_THAT(message_of([&] { (void)select_interface(log, "can7", file); }), HasSubstr("can0, can1"));
}

}  // namespace
}  // namespace sextant
