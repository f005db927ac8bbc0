// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl read` and `mbgatectl write` on the command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ctl/options/server_options.hpp"
#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// What both have: where the values are, of what type, and the server.
class PlaceOptions {
 public:
  PlaceOptions() = default;
  PlaceOptions(const PlaceOptions&) = delete;
  PlaceOptions& operator=(const PlaceOptions&) = delete;

  /// `tables`: the words for those that may be named. `command` keeps references to this object.
  void add_to(CLI::App& command, const std::vector<std::string>& tables);
  [[nodiscard]] Result<Place, std::string> place() const;
  [[nodiscard]] Result<Target, std::string> target() const;

 private:
  std::string table_;
  std::string address_;
  std::string type_;
  std::string order_ = "big";
  unsigned unit_ = 1;
  ServerOptions server_;
};

class ReadOptions {
 public:
  explicit ReadOptions(CLI::App& app);
  ReadOptions(const ReadOptions&) = delete;
  ReadOptions& operator=(const ReadOptions&) = delete;

  [[nodiscard]] bool given() const;
  /// The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const;

 private:
  CLI::App* read_;
  PlaceOptions where_;
  ReadCommand words_;
  std::optional<std::string> every_;
};

class WriteOptions {
 public:
  explicit WriteOptions(CLI::App& app);
  WriteOptions(const WriteOptions&) = delete;
  WriteOptions& operator=(const WriteOptions&) = delete;

  [[nodiscard]] bool given() const;
  /// The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const;

 private:
  CLI::App* write_;
  PlaceOptions where_;
  WriteCommand words_;
  std::string first_value_;
  std::vector<std::string> more_values_;
};

}  // namespace mbgate::ctl
