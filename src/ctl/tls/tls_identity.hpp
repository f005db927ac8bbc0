// SPDX-License-Identifier: Apache-2.0
// Who we are to a server over TLS, and whom we take it for.
#pragma once

#include <filesystem>
#include <string>

namespace mbgate::ctl {

struct TlsIdentity {
  std::filesystem::path certificate;  ///< ours, in PEM, with those between it and its authority
  std::filesystem::path key;
  std::filesystem::path authorities;  ///< who may have signed the server's certificate
  std::string server_name;            ///< that it is for; empty: the host that is connected to
};

}  // namespace mbgate::ctl
