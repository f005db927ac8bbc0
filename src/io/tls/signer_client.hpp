// SPDX-License-Identifier: Apache-2.0
// One private key that mbgate-signer holds: its public half, and signatures. A question takes
// about as long as the signature; a signer that does not answer is given up after a while, and is
// not asked for signatures for a second then.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/signing.hpp"
#include "bus/instant.hpp"
#include "modbus/result.hpp"
#include "sys/openssl.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

using Octets = std::vector<std::uint8_t>;

class SignerClient {
 public:
  /// Why there is no key. `absent`: the signer is not there, or does not answer; it may come.
  struct Failure {
    std::string why;
    bool absent = false;
  };

  /// Asks the signer at this socket for a key by the name of its file. It may take seconds.
  static Result<std::shared_ptr<SignerClient>, Failure> open(std::string socket, std::string key);

  /// A SubjectPublicKeyInfo in DER.
  [[nodiscard]] const Octets& public_key() const { return public_key_; }
  /// Why not: there is no signer any more, it does not answer within 200 ms or has not a moment
  /// ago, it has another key under this name, or it refuses. A signer that was started again is
  /// asked once more. Any thread may ask.
  Result<Octets, std::string> sign(signing::Question how, std::span<const std::uint8_t> bytes);

 private:
  SignerClient(std::string socket, std::string key)
      : path_(std::move(socket)), key_(std::move(key)) {}

  /// Connects and opens the key. What it answers, or why not.
  Result<Octets, Failure> connect(bus::Instant limit);
  /// Nothing if the connection is broken, or it takes longer.
  std::optional<Octets> ask(signing::Question question, std::span<const std::uint8_t> bytes,
                            bus::Instant limit);
  std::optional<std::string> open_again(bus::Instant limit);
  [[nodiscard]] Failure absent(const std::string& why) const;

  std::string path_;
  std::string key_;
  Octets public_key_;
  std::mutex mutex_;  ///< of the connection: a reload may use the key while the old one still signs
  sys::UniqueFd socket_;
};

/// A private key of RSA or EC that is not in this process: whatever needs it asks `signer`. Nothing
/// if OpenSSL does not take it.
sys::KeyHandle remote_key(std::shared_ptr<SignerClient> signer);

}  // namespace mbgate::io
