// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl cert` on the command line, which has subcommands of its own.
#pragma once

#include <string>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

class CertOptions {
 public:
  explicit CertOptions(CLI::App& app);
  CertOptions(const CertOptions&) = delete;
  CertOptions& operator=(const CertOptions&) = delete;

  [[nodiscard]] bool given() const;
  /// The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const;

 private:
  [[nodiscard]] Result<Command, std::string> server() const;
  [[nodiscard]] Result<Command, std::string> client() const;

  CLI::App* cert_;
  CLI::App* make_authority_;
  CLI::App* make_server_;
  CLI::App* make_client_;
  CLI::App* revoke_;
  CLI::App* renew_;
  CLI::App* show_;
  MakeAuthority authority_words_;
  MakeServer server_words_;
  MakeClient client_words_;
  Revoke revoke_words_;
  RenewList renew_words_;
  ShowCertificate show_words_;
};

}  // namespace mbgate::ctl
