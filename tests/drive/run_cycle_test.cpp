#include "sextant/drive/run_cycle.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drive/fake_controller.hpp"

namespace sextant {
namespace {

using Calls = std::vector<std::string>;

class RecordingIo final : public DriveIo<double> {
 public:
  explicit RecordingIo(Calls& calls) : calls_{calls} {}
  [[nodiscard]] Measurement<double> read(std::int64_t /*t_ns*/) noexcept override {
    calls_.push_back("read");
    Measurement<double> m;
    m.u_dc = 530;
    m.omega_m = 42;
    return m;
  }
  void write(const GatePattern& pattern) noexcept override {
    calls_.push_back("write");
    written = pattern;
  }
  GatePattern written{};

 private:
  Calls& calls_;
};

struct RecordingCommands {
  Calls& calls;
  DriveRequest<double> request{};
  std::int64_t asked_at{};
  DriveRequest<double> latest(std::int64_t t_ns) noexcept {
    calls.push_back("latest");
    asked_at = t_ns;
    return request;
  }
};

struct RecordingSink {
  Calls& calls;
  Telemetry<double> last{};
  void push(const Telemetry<double>& x) noexcept {
    calls.push_back("push");
    last = x;
  }
};

TEST(RunCycle, ReadsThenFetchesTheCommandThenWritesThenReports) {
  Calls calls;
  RecordingIo io{calls};
  RecordingCommands commands{calls};
  RecordingSink sink{calls};
  test::FakeController<double> controller;
  Drive<double> drive{Drive<double>::Parameters{}, controller};
  run_cycle(75'000, io, commands, drive, sink);
  EXPECT_EQ(calls, (Calls{"read", "latest", "write", "push"}));
  EXPECT_EQ(commands.asked_at, 75'000);
  EXPECT_EQ(io.written, (GatePattern{gates_off, 25'000}));
  EXPECT_EQ(sink.last.t_ns, 75'000);
  EXPECT_EQ(sink.last.omega_m, 42);
  EXPECT_EQ(sink.last.state, DriveState::standby);
}

struct RecordingProbe {
  Calls& calls;
  void begins(std::int64_t t_ns) noexcept { calls.push_back("begins " + std::to_string(t_ns)); }
  void has_read(const Measurement<double>& m) noexcept {
    calls.push_back("has_read " + std::to_string(int(m.u_dc)));
  }
  void has_request(const DriveRequest<double>& r) noexcept {
    calls.push_back(r.shutdown ? "has_request shutdown" : "has_request");
  }
  void has_stepped(const DriveOutput<double>& output) noexcept {
    calls.push_back("has_stepped " + std::to_string(output.telemetry.t_ns));
  }
  void has_written() noexcept { calls.push_back("has_written"); }
  void has_pushed() noexcept { calls.push_back("has_pushed"); }
};

TEST(RunCycle, AProbeSeesEachStepAfterIt) {
  Calls calls;
  RecordingIo io{calls};
  RecordingCommands commands{calls, {.shutdown = true}};
  RecordingSink sink{calls};
  RecordingProbe probe{calls};
  test::FakeController<double> controller;
  Drive<double> drive{Drive<double>::Parameters{}, controller};
  run_cycle(50'000, io, commands, drive, sink, probe);
  EXPECT_EQ(calls, (Calls{"begins 50000", "read", "has_read 530", "latest", "has_request shutdown",
                          "has_stepped 50000", "write", "has_written", "push", "has_pushed"}));
}

TEST(RunCycle, WhatIsWrittenIsWhatTheControllerDecided) {
  Calls calls;
  RecordingIo io{calls};
  RecordingCommands commands{calls};
  RecordingSink sink{calls};
  test::FakeController<double> controller;
  Drive<double> drive{Drive<double>::Parameters{}, controller};
  std::int64_t t_ns = 0;
  const auto receive = [&](bool enable) {
    auto& c = commands.request.command;
    ++c.sequence;
    c.e2e = E2eState::valid;
    c.enable = enable;
    c.torque = 15;
    c.torque_limit = 20;
    c.received_ns = t_ns;
    for (int k = 0; k < 3; ++k) run_cycle(t_ns += 25'000, io, commands, drive, sink);
  };
  receive(false);
  EXPECT_EQ(io.written.last_state(), gates_off);
  receive(true);
  EXPECT_EQ(io.written.last_state(), switch_states[1]);
  EXPECT_EQ(sink.last.state, DriveState::torque);
}

// The measurement carries no time: a power stage cannot keep an old command alive.
TEST(RunCycle, SilenceEndsTheTorqueByTheTimeOfTheCycle) {
  Calls calls;
  RecordingIo io{calls};
  RecordingCommands commands{calls};
  RecordingSink sink{calls};
  test::FakeController<double> controller;
  Drive<double> drive{Drive<double>::Parameters{}, controller};
  constexpr std::int64_t ms = 1'000'000;
  std::int64_t t_ns = 0;
  const auto run_to = [&](std::int64_t end_ns) {
    while (t_ns < end_ns) run_cycle(t_ns += 25'000, io, commands, drive, sink);
  };
  const auto receive = [&](bool enable) {
    auto& c = commands.request.command;
    c = {
        .torque = 20, .torque_limit = 150, .enable = enable, .received_ns = t_ns, .sequence = c.sequence + 1};
    c.e2e = E2eState::valid;
  };
  receive(false);
  run_to(5 * ms);
  receive(true);
  run_to(10 * ms);
  ASSERT_EQ(sink.last.torque_reference, 20);
  run_to(5 * ms + 60 * ms);
  EXPECT_EQ(sink.last.torque_reference, 0);
  run_to(5 * ms + 201 * ms);
  EXPECT_EQ(sink.last.state, DriveState::fault);
  EXPECT_EQ(sink.last.first_fault, Fault::command_lost);
  EXPECT_EQ(io.written.last_state(), gates_off);
  run_to(10'000 * ms);
  EXPECT_EQ(sink.last.state, DriveState::fault);
  EXPECT_EQ(sink.last.t_ns, t_ns);
}

}  // namespace
}  // namespace sextant
