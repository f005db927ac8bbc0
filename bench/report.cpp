// SPDX-License-Identifier: Apache-2.0
#include "report.hpp"

#include <sys/utsname.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <iomanip>
#include <numeric>
#include <optional>
#include <ostream>
#include <sstream>
#include <thread>

namespace mbgate::bench {
namespace {

namespace json = boost::json;

/// How a contestant is compared with the first one.
enum class Against : std::uint8_t { nothing, ratio, difference };

/// What stands for all runs: a single wrong answer must be seen.
enum class Over : std::uint8_t { median, sum };

struct Figure {
  const char* key;    ///< in JSON
  const char* title;  ///< in the table, with the unit
  int digits;         ///< behind the point
  Against against;
  Over over = Over::median;
};

// The order is that of values_of().
constexpr Figure kFigures[] = {
    {"answers_per_second", "answers a second", 1, Against::ratio},
    {"wire_per_second", "transactions a second on the wire", 1, Against::ratio},
    {"share_percent", "share of the wire's limit, %", 2, Against::ratio},
    {"least_bus_per_second", "of the slowest bus", 1, Against::ratio},
    {"dead_time_p50_us", "dead time p50, us", 1, Against::difference},
    {"dead_time_p90_us", "dead time p90, us", 1, Against::difference},
    {"dead_time_p99_us", "dead time p99, us", 1, Against::difference},
    {"dead_time_most_us", "dead time, most, us", 1, Against::nothing},
    {"latency_p50_us", "latency p50, us", 1, Against::ratio},
    {"latency_p99_us", "latency p99, us", 1, Against::ratio},
    {"latency_p999_us", "latency p99.9, us", 1, Against::ratio},
    {"over_wire_p50_us", "latency p50 above the wire's time, us", 1, Against::difference},
    {"over_wire_p99_us", "latency p99 above the wire's time, us", 1, Against::difference},
    {"over_wire_p999_us", "latency p99.9 above it, us", 1, Against::difference},
    {"processor_us", "CPU an answer, us", 2, Against::ratio},
    {"switches_per_second", "context switches a second", 1, Against::nothing},
    {"handshakes_per_second", "TLS handshakes a second", 1, Against::ratio},
    {"resident_kib", "memory (RSS), KiB", 0, Against::difference},
    {"allocations_per_thousand", "allocations in 1000 answers", 2, Against::nothing},
    {"violations", "silence violations, of all runs", 0, Against::nothing, Over::sum},
    {"bad_frames", "bad frames on the wire", 0, Against::nothing, Over::sum},
    {"wrong", "wrong answers, of all runs", 0, Against::nothing, Over::sum},
    {"exceptions", "exceptions", 0, Against::nothing, Over::sum},
    {"lost", "connections lost", 0, Against::nothing, Over::sum},
    {"unanswered", "not answered in time", 0, Against::nothing, Over::sum},
    {"late_p50_us", "simulator late p50, us", 1, Against::nothing},
    {"late_p99_us", "simulator late p99, us", 1, Against::nothing},
};
constexpr std::size_t kCount = std::size(kFigures);
using Values = std::vector<double>;  ///< one a figure; not a number: nobody measured it

double microseconds(Nanoseconds duration) { return static_cast<double>(duration.count()) / 1000; }

double quotient(double dividend, double divisor) {
  return divisor == 0 ? std::nan("") : dividend / divisor;
}

double number(std::uint64_t count) { return static_cast<double>(count); }

/// How many transactions a request waits for, its own included, if the wire is never free.
std::int64_t turns_of(const Scenario& scenario) {
  const LoadSettings& load = scenario.load;
  const unsigned turns = load.clients * load.outstanding / scenario.plant.buses;
  return load.same ? 1 : std::max(1U, turns);
}

Values values_of(const Scenario& scenario, const RunResult& run) {
  std::uint64_t violations = 0;
  std::uint64_t bad_frames = 0;
  Spread dead_time;
  Spread lateness;
  double wire_rate = 0;
  double least = std::nan("");
  for (const WireFigures& bus : run.buses) {
    wire_rate += bus.rate(run.seconds);
    violations += bus.violations;
    bad_frames += bus.bad_frames;
    least = std::fmin(least, bus.rate(run.seconds));
    // Of several buses, the worst.
    const auto worse = [](Spread& worst, const Spread& spread) {
      worst.p50 = std::max(worst.p50, spread.p50);
      worst.p90 = std::max(worst.p90, spread.p90);
      worst.p99 = std::max(worst.p99, spread.p99);
      worst.most = std::max(worst.most, spread.most);
    };
    worse(dead_time, bus.dead_time.spread());
    worse(lateness, bus.lateness.spread());
  }
  const Plant& plant = scenario.plant;
  const double limit = number(plant.buses) * 1e6 / microseconds(plant.exchange());
  const double answers = number(run.clients.answers);
  const double nan = std::nan("");
  const Spread& latency = run.clients.latency;
  const bool answered = latency.p50.count() > 0;
  const Nanoseconds wire_time = plant.exchange() * turns_of(scenario);
  return {
      quotient(answers, run.clients.seconds),
      wire_rate,
      plant.paced() ? 100 * wire_rate / limit : nan,
      plant.buses > 1 ? least : nan,
      plant.paced() ? microseconds(dead_time.p50) : nan,
      plant.paced() ? microseconds(dead_time.p90) : nan,
      plant.paced() ? microseconds(dead_time.p99) : nan,
      plant.paced() ? microseconds(dead_time.most) : nan,
      answered ? microseconds(latency.p50) : nan,
      answered ? microseconds(latency.p99) : nan,
      answered ? microseconds(latency.p999) : nan,
      plant.paced() && answered ? microseconds(latency.p50 - wire_time) : nan,
      plant.paced() && answered ? microseconds(latency.p99 - wire_time) : nan,
      plant.paced() && answered ? microseconds(latency.p999 - wire_time) : nan,
      quotient(microseconds(run.used.processor), answers),
      number(run.used.context_switches) / run.seconds,
      scenario.load.handshakes > 0 ? number(run.handshakes) / run.seconds : nan,
      number(run.used.resident) / 1024,
      run.allocations ? quotient(1000 * number(*run.allocations), answers) : nan,
      plant.paced() ? number(violations) : nan,
      number(bad_frames),
      number(run.clients.wrong),
      number(run.clients.exceptions),
      number(run.clients.lost),
      number(run.clients.unanswered),
      plant.paced() ? microseconds(lateness.p50) : nan,
      plant.paced() ? microseconds(lateness.p99) : nan,
  };
}

double median(Values values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) {
    return std::nan("");
  }
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// All runs of a contestant: a line a run.
std::vector<Values> all_values(const Contest& contest) {
  std::vector<Values> lines;
  lines.reserve(contest.runs.size());
  for (const RunResult& run : contest.runs) {
    lines.push_back(values_of(contest.scenario, run));
  }
  return lines;
}

/// One value for all runs.
double summary(const std::vector<Values>& runs, std::size_t figure) {
  Values values;
  for (const Values& run : runs) {
    values.push_back(run[figure]);
  }
  return kFigures[figure].over == Over::sum ? std::accumulate(values.begin(), values.end(), 0.0)
                                            : median(values);
}

/// The median over the pairs.
double against(const std::vector<Values>& first, const std::vector<Values>& other,
               std::size_t figure) {
  Values values;
  for (std::size_t pair = 0; pair < std::min(first.size(), other.size()); ++pair) {
    values.push_back(kFigures[figure].against == Against::ratio
                         ? quotient(other[pair][figure], first[pair][figure])
                         : other[pair][figure] - first[pair][figure]);
  }
  return median(values);
}

std::string text(double value, int digits) {
  if (std::isnan(value)) {
    return "-";
  }
  std::ostringstream stream;
  stream << std::fixed << std::setprecision(digits) << value;
  return std::move(stream).str();
}

json::value json_number(double value) {
  return std::isnan(value) ? json::value() : json::value(value);
}

json::object json_figures(const Values& values) {
  json::object object;
  for (std::size_t figure = 0; figure < kCount; ++figure) {
    object[kFigures[figure].key] = json_number(values[figure]);
  }
  return object;
}

json::object json_scenario(const Scenario& scenario) {
  const Plant& plant = scenario.plant;
  const LoadSettings& load = scenario.load;
  return {{"name", scenario.name},
          {"program", scenario.program},
          {"baud", plant.baud},
          {"buses", plant.buses},
          {"devices", plant.devices},
          {"dead", plant.dead},
          {"registers", plant.registers},
          {"clients", load.clients},
          {"outstanding", load.outstanding},
          {"same", load.same},
          {"idle", load.idle},
          {"flood", load.flood},
          {"tls", load.tls},
          {"handshakes", load.handshakes},
          {"coalesce", scenario.coalesce},
          {"wake_early_us", scenario.wake_early},
          {"exchange_us", microseconds(plant.exchange())}};
}

}  // namespace

void print_table(std::ostream& out, const std::vector<Contest>& contests) {
  std::vector<std::vector<Values>> values;
  constexpr int kTitle = 40;
  out << std::left << std::setw(kTitle) << "median of " + std::to_string(contests[0].runs.size())
      << std::right;
  std::vector<int> widths;
  for (const Contest& contest : contests) {
    values.push_back(all_values(contest));
    widths.push_back(std::max(22, static_cast<int>(contest.scenario.name.size()) + 2));
    out << std::setw(widths.back()) << contest.scenario.name;
  }
  out << "\n";
  for (std::size_t figure = 0; figure < kCount; ++figure) {
    const auto& [key, title, digits, comparison, over] = kFigures[figure];
    out << std::left << std::setw(kTitle) << title << std::right;
    for (std::size_t column = 0; column < values.size(); ++column) {
      std::string cell = text(summary(values[column], figure), digits);
      const double compared = against(values[0], values[column], figure);
      if (column > 0 && comparison != Against::nothing && !std::isnan(compared)) {
        const bool ratio = comparison == Against::ratio;
        cell += ratio ? "  x " + text(compared, 3)
                      : (compared < 0 ? "  " : "  +") + text(compared, digits);
      }
      out << std::setw(widths[column]) << cell;
    }
    out << "\n";
  }
  out << std::flush;
}

std::string to_json(const std::vector<Contest>& contests, const std::vector<std::string>& command) {
  utsname kernel{};
  ::uname(&kernel);
  json::array list;
  const auto first = all_values(contests[0]);
  for (const Contest& contest : contests) {
    const auto runs = all_values(contest);
    json::array single;
    for (const Values& run : runs) {
      single.push_back(json_figures(run));
    }
    Values medians;
    Values compared;
    for (std::size_t figure = 0; figure < kCount; ++figure) {
      medians.push_back(summary(runs, figure));
      const bool has_ratio = kFigures[figure].against != Against::nothing;
      compared.push_back(has_ratio ? against(first, runs, figure) : std::nan(""));
    }
    list.push_back(json::object{{"scenario", json_scenario(contest.scenario)},
                                {"median", json_figures(medians)},
                                {"against_first", json_figures(compared)},
                                {"runs", std::move(single)}});
  }
  return json::serialize(json::object{{"command", json::value_from(command)},
                                      {"kernel", std::string(kernel.release)},
                                      {"processors", std::thread::hardware_concurrency()},
                                      {"contestants", std::move(list)}});
}

}  // namespace mbgate::bench
