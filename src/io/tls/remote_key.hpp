// SPDX-License-Identifier: Apache-2.0
// A private key for OpenSSL that is not in this process: whatever needs it asks mbgate-signer.
#pragma once

#include <memory>
#include <string>

#include "io/tls/signer_client.hpp"
#include "sys/openssl.hpp"

namespace mbgate::io {

/// A key of RSA or EC, as `signer` has it. Nothing if OpenSSL does not take it.
sys::KeyHandle remote_key(std::shared_ptr<SignerClient> signer);

}  // namespace mbgate::io
