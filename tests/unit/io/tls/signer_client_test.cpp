// SPDX-License-Identifier: Apache-2.0
// A signer that does not answer, or answers something else. That it signs is shown with the program
// (tests/integration/tls_test.py).
#include "io/tls/signer_client.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

namespace mbgate::io {
namespace {

/// Takes one connection, and gives these answers; then it is silent until it ends.
class FalseSigner {
 public:
  explicit FalseSigner(std::vector<std::string> answers) {
    ::mkdtemp(folder_.data());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::ranges::copy(path(), address.sun_path);
    ::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
    ::listen(listener_.get(), 5);
    thread_ = std::thread([this, answers = std::move(answers)] {
      connection_ = sys::UniqueFd(::accept(listener_.get(), nullptr, nullptr));
      std::array<char, 2048> question{};
      for (const std::string& answer : answers) {
        ::recv(connection_.get(), question.data(), question.size(), 0);
        ::send(connection_.get(), answer.data(), answer.size(), MSG_NOSIGNAL);
      }
    });
  }
  FalseSigner(const FalseSigner&) = delete;
  FalseSigner& operator=(const FalseSigner&) = delete;
  ~FalseSigner() {
    thread_.join();
    std::filesystem::remove_all(folder_);
  }

  [[nodiscard]] std::string path() const { return folder_ + "/signer"; }

 private:
  std::string folder_ = (std::filesystem::temp_directory_path() / "mbgate-signer-XXXXXX").string();
  sys::UniqueFd listener_{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)};
  sys::UniqueFd connection_;
  std::thread thread_;
};

const Octets kDigest(32, 0x5A);

TEST(SignerClientTest, GivesASilentSignerUpAndDoesNotAskItAtOnce) {
  const FalseSigner signer({"Kpublic"});
  const auto client = SignerClient::open(signer.path(), "key");
  ASSERT_TRUE(client);
  const auto first = (*client)->sign(signing::Question::ecdsa, kDigest);
  ASSERT_FALSE(first);
  EXPECT_EQ(first.error(), "mbgate-signer does not answer");
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 1000; ++i) {  // 200 s if each waited
    EXPECT_FALSE((*client)->sign(signing::Question::ecdsa, kDigest));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(100));
}

TEST(SignerClientTest, SaysThatItIsRefused) {
  const FalseSigner signer({"Kpublic", "Fwhy not"});
  const auto client = SignerClient::open(signer.path(), "key");
  ASSERT_TRUE(client);
  const auto refused = (*client)->sign(signing::Question::ecdsa, kDigest);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), "mbgate-signer refuses to sign");
}

TEST(SignerClientTest, SaysThatThereIsNoneAnyMore) {
  std::string path;
  std::shared_ptr<SignerClient> kept;
  {
    const FalseSigner signer({"Kpublic"});
    path = signer.path();
    const auto client = SignerClient::open(path, "key");
    ASSERT_TRUE(client);
    kept = *client;
  }
  const auto gone = kept->sign(signing::Question::ecdsa, kDigest);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error(), "mbgate-signer (" + path + "): No such file or directory");
}

}  // namespace
}  // namespace mbgate::io
