// SPDX-License-Identifier: Apache-2.0
// mbgated in front of one Modbus TCP server, and how to ask through it.
#pragma once

#include <gmock/gmock.h>

#include <thread>

#include "integration/far_server.hpp"
#include "integration/plant.hpp"

namespace mbgate::test {

inline constexpr unsigned kUnit = 1;
/// Register 10 of the far server.
inline constexpr auto kRead = "03 000A 0001";

inline constexpr auto kPatient = "response_timeout = \"20s\"";
inline constexpr auto kPatientWithFour = "response_timeout = \"20s\"\noutstanding = 4";
inline constexpr auto kImpatient = "response_timeout = \"500ms\"";

/// The answer without its transaction identifier; "" if there is none.
inline std::string pdu_of(const std::optional<ByteString>& answer) {
  return answer && answer->size() > 7 ? text_of({answer->begin() + 7, answer->end()}) : "";
}

inline std::string ask(TcpClient& client, std::string_view pdu, unsigned unit = kUnit) {
  client.send(request(0x1234, unit, pdu));
  return pdu_of(client.receive());
}

/// Asks until the answer is no exception any more: the connection is there, and the server was in
/// time. The last exception if that takes longer than anything may.
inline std::string ask_until_answered(TcpClient& client, std::string_view pdu) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    std::string answer = ask(client, pdu);
    if (!answer.starts_with('8') || std::chrono::steady_clock::now() > end) {
      return answer;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
}

inline bool serves(TcpClient& client) { return ask_until_answered(client, kRead).starts_with('0'); }

/// A gateway with one bus: the listener "far" is bound to it, and unit 5 of the listener "routed"
/// is the one device on it.
class NearGateway {
 public:
  NearGateway(std::uint16_t far_port, const std::string& keys)
      : gateway_("mbgated", {"--config", config(far_port, keys).string()}, {folder_.path(), {}}),
        port_(gateway_.port_of("far")),
        routed_port_(gateway_.port_of("routed")) {
    TcpClient client(port_);
    EXPECT_TRUE(serves(client)) << gateway_.output();
  }

  [[nodiscard]] TcpClient client() const { return TcpClient(port_); }
  [[nodiscard]] TcpClient routed_client() const { return TcpClient(routed_port_); }
  Process& process() { return gateway_; }

 private:
  [[nodiscard]] std::filesystem::path config(std::uint16_t far_port,
                                             const std::string& keys) const {
    return folder_.write("mbgate.toml",
                         "[[listen]]\nname = \"far\"\nport = 0\nbus = \"far\"\n"
                         "[[listen]]\nname = \"routed\"\nport = 0\n"
                         "[[bus]]\nname = \"far\"\nmode = \"tcp\"\nhost = \"127.0.0.1\"\nport = " +
                             std::to_string(far_port) + "\nretries = 0\n" + keys +
                             "\n[[device]]\nname = \"drive\"\nbus = \"far\"\n"
                             "[[route]]\nlistener = \"routed\"\nunit = 5\ndevice = \"drive\"\n");
  }

  TemporaryFolder folder_;
  Process gateway_;
  std::uint16_t port_;
  std::uint16_t routed_port_;
};

}  // namespace mbgate::test
