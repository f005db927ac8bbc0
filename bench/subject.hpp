// SPDX-License-Identifier: Apache-2.0
// What is measured: mbgated, one of the floors, or a gateway that a command of the user starts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "child.hpp"
#include "load.hpp"
#include "plant.hpp"

namespace mbgate::bench {

/// One contestant: who, at which plant, under which load.
struct Scenario {
  std::string name;     ///< as the user wrote it
  std::string program;  ///< "mbgated", "master", "relay", or a name of Means::commands
  Plant plant{};
  LoadSettings load{};
  bool coalesce = true;      ///< mbgated's key
  unsigned wake_early = 40;  ///< mbgated's key, in microseconds
};

/// What the harness has at hand.
struct Means {
  std::filesystem::path mbgated;                ///< the program
  std::filesystem::path folder;                 ///< for files of this run
  std::map<std::string, std::string> commands;  ///< with {device}, {baud} and {port}
  std::optional<std::filesystem::path>
      allocations;               ///< the library that counts them, to be preloaded
  std::filesystem::path signer;  ///< the program that holds mbgated's private key
};

/// Makes an authority, gateway.crt and gateway.key, client.crt and client.key in the folder. Throws
/// std::runtime_error.
void make_certificates(const std::filesystem::path& mbgate_cert,
                       const std::filesystem::path& folder);

/// A program under measurement, ready for its clients.
class Subject {
 public:
  /// Throws std::runtime_error: what is wrong, and what the program itself said of it.
  Subject(const Scenario& scenario, const Means& means, const std::vector<std::string>& paths);

  /// The ports of the buses, in their order; none: it takes no clients.
  [[nodiscard]] const Doors& doors() const { return doors_; }
  [[nodiscard]] std::uint16_t handshake_port() const { return handshake_port_; }
  [[nodiscard]] const TlsFiles& tls_files() const { return tls_files_; }
  [[nodiscard]] std::uint16_t flood_port() const { return flood_port_; }
  [[nodiscard]] const Child& process() const { return *child_; }
  /// How often it has asked for memory so far; nothing if nobody counts.
  [[nodiscard]] std::optional<std::uint64_t> allocations() const;

 private:
  void start_mbgated(const Scenario& scenario, const Means& means,
                     const std::vector<std::string>& paths);
  void start_signer(const Means& means);
  void start_relay(const Scenario& scenario, const std::string& path);
  void start_command(const Scenario& scenario, const Means& means, const std::string& path);
  [[nodiscard]] std::string said() const;

  std::filesystem::path log_;
  std::filesystem::path counter_;
  std::optional<Child> child_;
  std::optional<Child> signer_;
  TlsFiles tls_files_;
  Doors doors_;
  std::uint16_t flood_port_ = 0;
  std::uint16_t handshake_port_ = 0;
};

}  // namespace mbgate::bench
