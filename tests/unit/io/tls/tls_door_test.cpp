// SPDX-License-Identifier: Apache-2.0
// Who makes room for another handshake. The handshakes themselves are shown with other programs
// (tests/integration/tls_test.py).
#include "io/tls/tls_door.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "unit/io/run_until.hpp"
#include "unit/io/tls/made_authority.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;

constexpr gateway::ListenerId kListener{0};

class TlsDoorTest : public testing::Test, public TlsEvents {
 public:
  ~TlsDoorTest() override { std::filesystem::remove_all(folder_); }

  void tls_arrived(TlsArrival /*arrival*/) override {}
  void tls_refused(const TlsPlace& place, const std::string& why) override {
    refused_.push_back(place.address.to_text() + ": " + why);
  }
  void tls_behind(std::chrono::milliseconds /*missed*/) override {}
  void tls_drained() override {}

 protected:
  using Texts = std::vector<std::string>;

  TlsDoorTest() {
    ::mkdtemp(folder_.data());
    const MadeAuthority made = make_authority("Plant");
    std::ofstream(folder_ + "/made.crt") << made.certificate;
    gateway::TlsSettings tls{.name = "x"};
    tls.certificate = tls.authorities = folder_ + "/made.crt";
    // Nobody gets so far here that the key would be needed.
    door_.use({{kListener, *TlsContext::make(tls, {})}});
    settings_.listeners.resize(1);
    settings_.listeners.front().handshakes = {.timeout = std::chrono::minutes(2),
                                              .hello = std::chrono::minutes(2),
                                              .at_a_time = 3,
                                              .for_one_client = 2,
                                              .per_second = 0,
                                              .per_second_for_one_client = 0};
  }

  /// A client that says nothing.
  void connect_from(const char* address) {
    tcp::socket far(context_);
    far.connect(acceptor_.local_endpoint());
    clients_.push_back(std::move(far));
    const auto peer = boost::asio::ip::make_address(address);
    tcp::socket near = acceptor_.accept();
    near.native_non_blocking(true);  // as TcpServer's are
    door_.take(kListener, settings_, {std::move(near), {peer, 1}});
  }

  /// Who has been let go, and why, when so many have.
  Texts refused(std::size_t count) {
    EXPECT_TRUE(run_until(context_, [&] { return refused_.size() >= count; }));
    return refused_;
  }

  std::string folder_ = (std::filesystem::temp_directory_path() / "mbgate-door-XXXXXX").string();
  boost::asio::io_context context_;
  tcp::acceptor acceptor_{context_, tcp::endpoint(boost::asio::ip::address_v4::loopback(), 0)};
  std::vector<tcp::socket> clients_;
  Texts refused_;
  gateway::Settings settings_;
  TlsDoor door_{context_, *this};
};

constexpr const char* kGoes =
    ": no TLS handshake: closed for another client, because no ClientHello had come (";

TEST_F(TlsDoorTest, LetsTheOldestSilentOneGo) {
  for (const char* client : {"10.0.0.1", "10.0.0.2", "10.0.0.3", "10.0.0.4", "10.0.0.5"}) {
    connect_from(client);
  }
  EXPECT_EQ(refused(2), (Texts{std::string("10.0.0.1") + kGoes + "max_handshakes)",
                               std::string("10.0.0.2") + kGoes + "max_handshakes)"}));
  EXPECT_EQ(door_.under_way(), 3U);
}

TEST_F(TlsDoorTest, AClientHasItsOwnOldestGo) {
  for (const char* client : {"10.0.0.1", "10.0.0.2", "10.0.0.2", "10.0.0.2"}) {
    connect_from(client);
  }
  EXPECT_EQ(refused(1), Texts{std::string("10.0.0.2") + kGoes + "max_handshakes_per_client)"});
  EXPECT_EQ(door_.under_way(), 3U);
}

TEST_F(TlsDoorTest, CountsClientsOfIpv6ByTheirNetwork) {
  for (const char* client : {"2001:db8:0:1::1", "2001:db8:0:1::2", "2001:db8:0:2::1"}) {
    connect_from(client);
  }
  EXPECT_EQ(door_.under_way(), 3U);
  connect_from("2001:db8:0:1:ffff::3");
  EXPECT_EQ(refused(1),
            Texts{std::string("2001:db8:0:1::1") + kGoes + "max_handshakes_per_client)"});
}

TEST_F(TlsDoorTest, WhoMayBeginNoneHasNobodysPlace) {
  settings_.listeners.front().handshakes.per_second_for_one_client = 1;
  for (const char* client : {"10.0.0.1", "10.0.0.2", "10.0.0.3", "10.0.0.3"}) {
    connect_from(client);
  }
  EXPECT_EQ(refused(1), Texts{"10.0.0.3: too many handshakes of one client "
                              "(max_handshakes_per_second_per_client)"});
  EXPECT_EQ(door_.under_way(), 3U);
}

}  // namespace
}  // namespace mbgate::io
