// Work and precision of the plant integrators: one JSON object on standard output. See
// scripts/work_precision.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <time.h>

#include "bench/closed_loops.hpp"
#include "support/recorded_switching.hpp"

namespace sextant::bench {
namespace {

using Plant = DrivePlant<double>;
using Integrator = PlantIntegrator<Plant>;
using Clock = std::chrono::steady_clock;

/// What the shaft does: follow the torques, or turn at a constant speed.
enum class Shaft : std::uint8_t { free, held };

struct Trajectory {
  std::vector<double> tau_e{};               ///< at the end of each period [N·m]
  std::vector<SpaceVector<double>> psi_s{};  ///< [Wb]
};

class Run {
 public:
  Run(const std::vector<SwitchState>& sequence, Shaft shaft) : sequence_{sequence}, shaft_{shaft} {}

  [[nodiscard]] Trajectory trajectory(Integrator& integrator) const {
    Trajectory result;
    Plant plant = start(integrator);
    for (const SwitchState state : sequence_) {
      advance(plant, integrator, state);
      result.tau_e.push_back(plant.tau_e());
      result.psi_s.push_back(plant.psi_s());
    }
    return result;
  }

  /// Processor time of a whole run, in which other programs do not count. [s]
  [[nodiscard]] double cpu_time(Integrator& integrator) const {
    Plant plant = start(integrator);
    const double begin = thread_time();
    for (const SwitchState state : sequence_) advance(plant, integrator, state);
    return thread_time() - begin;
  }

  /// The least time of each period over `runs`, which leaves out what the machine did in between. [s]
  [[nodiscard]] std::vector<double> period_times(Integrator& integrator, int runs) const {
    std::vector<double> least(sequence_.size(), std::numeric_limits<double>::infinity());
    for (int n = 0; n < runs; ++n) {
      Plant plant = start(integrator);
      for (std::size_t k = 0; k < sequence_.size(); ++k) {
        const auto begin = Clock::now();
        advance(plant, integrator, sequence_[k]);
        least[k] = std::min(least[k], std::chrono::duration<double>(Clock::now() - begin).count());
      }
    }
    return least;
  }

 private:
  static double thread_time() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  }
  Plant start(Integrator& integrator) const {
    integrator.reset();
    Plant plant{DrivePlantParameters<double>{}};
    if (shaft_ == Shaft::held) plant.set_speed(60.0);
    return plant;
  }
  void advance(Plant& plant, Integrator& integrator, SwitchState state) const {
    plant.set_inputs({state, 530.0, 2.0, shaft_ == Shaft::held, 0.0});
    if (integrator.advance(plant, testing::recorded_period_ns)) return;
    std::fputs("sextant_work_precision: an integration failed\n", stderr);
    std::exit(1);
  }

  const std::vector<SwitchState>& sequence_;
  Shaft shaft_;
};

double torque_error(const Trajectory& a, const Trajectory& b) {
  double error = 0.0;
  for (std::size_t k = 0; k < a.tau_e.size(); ++k) error = std::max(error, std::abs(a.tau_e[k] - b.tau_e[k]));
  return error;
}
double flux_error(const Trajectory& a, const Trajectory& b) {
  double error = 0.0;
  for (std::size_t k = 0; k < a.psi_s.size(); ++k)
    error = std::max(error, magnitude(a.psi_s[k] - b.psi_s[k]));
  return error;
}

struct Entry {
  std::string integrator;
  std::string setting;
  std::function<std::unique_ptr<Integrator>()> make;
  bool is_default{false};
};

std::vector<Entry> entries() {
  std::vector<Entry> list;
  for (const std::int32_t ns : {25'000, 12'500, 6'250, 2'500}) {
    const std::string step = fmt::format("{:g} us", ns * 1e-3);
    list.push_back({"fixed", step,
                    [ns] { return std::make_unique<FixedStepIntegrator<Plant>>(FixedStepParameters{ns}); },
                    ns == 25'000});
    list.push_back({"exact", step,
                    [ns] { return std::make_unique<ExactIntegrator<Plant>>(ExactParameters{ns}); },
                    ns == 25'000});
  }
  list.push_back({"erk", "default", [] { return std::make_unique<ErkIntegrator<Plant>>(); }, true});
  list.push_back({"cvode", "default", [] { return std::make_unique<CvodeIntegrator<Plant>>(); }, true});
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const std::string setting = fmt::format("{:.0e}", tolerance);
    list.push_back({"cvode", setting,
                    [tolerance] { return std::make_unique<CvodeIntegrator<Plant>>(cvode_at(tolerance)); }});
    list.push_back({"cvode_bdf", setting, [tolerance] {
                      return std::make_unique<CvodeIntegrator<Plant>>(
                          cvode_at(tolerance, CvodeMethod::bdf_newton));
                    }});
  }
  return list;
}

double percentile(std::vector<double> values, double fraction) {
  const auto nth = values.begin() + std::ptrdiff_t(fraction * double(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

nlohmann::json measure(const Entry& entry, const Run& run, const Trajectory& reference,
                       const Trajectory& at_1e_10, const Trajectory& at_1e_12, double duration_s) {
  const std::unique_ptr<Integrator> integrator = entry.make();
  const Trajectory trajectory = run.trajectory(*integrator);
  double cpu_s = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 5; ++n) cpu_s = std::min(cpu_s, run.cpu_time(*integrator));
  nlohmann::json result{{"integrator", entry.integrator},
                        {"setting", entry.setting},
                        {"default", entry.is_default},
                        {"torque_error_nm", torque_error(trajectory, reference)},
                        {"torque_difference_to_cvode_1e_10_nm", torque_error(trajectory, at_1e_10)},
                        {"torque_difference_to_cvode_1e_12_nm", torque_error(trajectory, at_1e_12)},
                        {"flux_error_wb", flux_error(trajectory, reference)},
                        {"cpu_s_per_simulated_s", cpu_s / duration_s}};
  if (!entry.is_default) return result;
  const std::vector<double> once = run.period_times(*integrator, 1);
  const std::vector<double> least = run.period_times(*integrator, 9);
  result["period_us"] = {{"median", 1e6 * percentile(once, 0.5)},
                         {"p99_9", 1e6 * percentile(once, 0.999)},
                         {"max", 1e6 * percentile(once, 1.0)},
                         {"max_of_least_of_9", 1e6 * percentile(least, 1.0)}};
  return result;
}

nlohmann::json measure_all(const std::vector<SwitchState>& sequence, Shaft shaft, double duration_s) {
  const Run run{sequence, shaft};
  // Runge-Kutta at 1 µs is the reference: CVODE converges to it as its tolerance falls, and is reported by
  // how far it is still away.
  CvodeIntegrator<Plant> tightest{cvode_at(1e-13)};
  CvodeIntegrator<Plant> tight{cvode_at(1e-12)};
  CvodeIntegrator<Plant> usual{cvode_at(1e-10)};
  FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000}};
  const Trajectory reference = run.trajectory(fine);
  const Trajectory at_1e_10 = run.trajectory(usual);
  const Trajectory at_1e_12 = run.trajectory(tight);
  nlohmann::json result{{"torque_error_of_cvode_nm",
                         {{"1e-10", torque_error(at_1e_10, reference)},
                          {"1e-12", torque_error(at_1e_12, reference)},
                          {"1e-13", torque_error(run.trajectory(tightest), reference)}}}};
  for (const Entry& entry : entries())
    result["points"].push_back(measure(entry, run, reference, at_1e_10, at_1e_12, duration_s));
  return result;
}

/// One recorded sequence of switching states under every integrator and several tolerances.
nlohmann::json switching() {
  constexpr double duration_s = 1.0;
  const std::vector<SwitchState> sequence = testing::record_switching(duration_s);
  std::size_t changes = 0;
  for (std::size_t k = 1; k < sequence.size(); ++k) changes += sequence[k] == sequence[k - 1] ? 0U : 1U;
  return {{"simulated_s", duration_s},
          {"period_us", 25},
          {"voltage_changes", changes},
          {"free_shaft", measure_all(sequence, Shaft::free, duration_s)},
          {"constant_speed", measure_all(sequence, Shaft::held, duration_s)}};
}

}  // namespace
}  // namespace sextant::bench

/// Without an argument everything, else the part of that name.
int main(int count, char** arguments) {
  const std::string_view part = count > 1 ? arguments[1] : "";
  nlohmann::json result;
  try {
    if (part != "closed_loops") result = sextant::bench::switching();
    if (part != "switching") result["closed_loops"] = sextant::bench::closed_loops();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sextant_work_precision: %s\n", error.what());
    return 1;
  }
  std::printf("%s\n", result.dump(1).c_str());
}
