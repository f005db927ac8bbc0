// SPDX-License-Identifier: Apache-2.0
#include "contestant.hpp"

#include <charconv>
#include <sstream>
#include <stdexcept>

namespace mbgate::bench {
namespace {

constexpr unsigned kMostAddress = 247;
constexpr unsigned kMostRegisters = 125;
constexpr unsigned kMostClients = 500;  ///< at 130 registers each

unsigned parse_number(const std::string& text, const std::string& place) {
  unsigned value = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || at != end) {
    throw std::invalid_argument(place + ": \"" + text + "\" is not a number");
  }
  return value;
}

void set(Scenario& scenario, const std::string& key, unsigned value, const std::string& place) {
  const std::map<std::string, unsigned*> numbers{{"baud", &scenario.plant.baud},
                                                 {"buses", &scenario.plant.buses},
                                                 {"devices", &scenario.plant.devices},
                                                 {"dead", &scenario.plant.dead},
                                                 {"registers", &scenario.plant.registers},
                                                 {"clients", &scenario.load.clients},
                                                 {"outstanding", &scenario.load.outstanding},
                                                 {"idle", &scenario.load.idle},
                                                 {"flood", &scenario.load.flood},
                                                 {"handshakes", &scenario.load.handshakes},
                                                 {"wake_early", &scenario.wake_early}};
  const std::map<std::string, bool*> flags{
      {"same", &scenario.load.same}, {"tls", &scenario.load.tls}, {"coalesce", &scenario.coalesce}};
  if (const auto found = numbers.find(key); found != numbers.end()) {
    *found->second = value;
  } else if (const auto flag = flags.find(key); flag != flags.end()) {
    *flag->second = value != 0;
  } else {
    throw std::invalid_argument(place + ": unknown key \"" + key +
                                "\"; there are baud, buses, devices, dead, registers, clients, "
                                "outstanding, same, idle, flood, tls, handshakes, "
                                "coalesce, wake_early");
  }
}

void check(const Scenario& scenario) {
  const Plant& plant = scenario.plant;
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(scenario.name + ": " + why);
  };
  if (plant.buses < 1) {
    refuse("a plant has at least one bus");
  }
  if (plant.devices < 1 || plant.devices > kMostAddress || plant.dead > plant.devices) {
    refuse("a bus has 1 to 247 devices, and not more dead ones");
  }
  if (plant.registers < 1 || plant.registers > kMostRegisters) {
    refuse("a request reads 1 to 125 registers");
  }
  if (scenario.load.outstanding < 1) {
    refuse("a client has at least one request outstanding");
  }
  if (scenario.load.clients > kMostClients && !scenario.load.same) {
    refuse("not more than 500 clients have registers of their own");
  }
  if (scenario.load.speaks_tls() && (scenario.program == "master" || scenario.program == "relay")) {
    refuse("neither master nor relay speaks TLS");
  }
  if (scenario.program == "relay" && (scenario.load.outstanding > 1 || plant.dead > 0)) {
    refuse("the relay takes one request at a time from a client, and waits for every answer");
  }
}

}  // namespace

std::map<std::string, std::string> parse_commands(const std::vector<std::string>& texts) {
  std::map<std::string, std::string> commands;
  for (const std::string& text : texts) {
    const auto sign = text.find('=');
    if (sign == std::string::npos || sign == 0) {
      throw std::invalid_argument("--command " + text + ": must be NAME=COMMAND");
    }
    commands[text.substr(0, sign)] = text.substr(sign + 1);
  }
  return commands;
}

Scenario parse_contestant(const std::string& text, const Scenario& common,
                          const std::map<std::string, std::string>& commands) {
  Scenario scenario = common;
  scenario.name = text;
  const auto colon = text.find(':');
  scenario.program = text.substr(0, colon);
  if (scenario.program != "mbgated" && scenario.program != "master" &&
      scenario.program != "relay" && !commands.contains(scenario.program)) {
    throw std::invalid_argument("\"" + scenario.program +
                                "\" is neither mbgated, master, relay nor a name of --command");
  }
  std::istringstream entries(colon == std::string::npos ? "" : text.substr(colon + 1));
  for (std::string entry; std::getline(entries, entry, ',');) {
    const auto sign = entry.find('=');
    if (sign == std::string::npos) {
      throw std::invalid_argument(text + R"(: ")" + entry + R"(" must be key=value)");
    }
    set(scenario, entry.substr(0, sign), parse_number(entry.substr(sign + 1), text), text);
  }
  check(scenario);
  return scenario;
}

}  // namespace mbgate::bench
