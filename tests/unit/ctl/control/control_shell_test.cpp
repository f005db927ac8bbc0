// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <future>

namespace mbgate::ctl {
namespace {

constexpr std::chrono::seconds kPatience{60};

/// A socket that somebody listens at.
class ControlShell : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = std::filesystem::temp_directory_path() / "mbgate.XXXXXX";
    ASSERT_NE(::mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    path_ = folder_ / "control";
    listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{AF_UNIX, {}};
    ASSERT_LT(path_.size(), sizeof address.sun_path);
    std::ranges::copy(path_, address.sun_path);
    ASSERT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(listener_, 1), 0);
  }
  void TearDown() override {
    ::close(listener_);
    std::filesystem::remove_all(folder_);
  }

  /// Takes one connection and its request, answers with this and closes. Returns the request.
  [[nodiscard]] std::future<std::string> serve(std::string answer) const {
    return std::async(std::launch::async, [listener = listener_, answer = std::move(answer)] {
      const int client = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
      std::string request;
      while (!request.ends_with("\r\n\r\n")) {
        std::array<char, 1000> piece{};
        const ssize_t count = ::read(client, piece.data(), piece.size());
        if (count <= 0) {
          break;
        }
        request.append(piece.data(), static_cast<std::size_t>(count));
      }
      EXPECT_EQ(::write(client, answer.data(), answer.size()), static_cast<ssize_t>(answer.size()));
      ::close(client);
      return request;
    });
  }

  std::filesystem::path folder_;
  std::string path_;
  int listener_ = -1;
};

TEST_F(ControlShell, GivesTheAnswer) {
  const auto request = serve("HTTP/1.1 200 OK\r\nContent-Length: 15\r\n\r\n{\"status\":\"ok\"}");
  const auto answer = ask_control(path_, "GET", "/healthz", kPatience);
  ASSERT_TRUE(answer) << answer.error();
  EXPECT_EQ(answer->status, 200U);
  EXPECT_EQ(answer->json.at("status").as_string(), "ok");
}

TEST_F(ControlShell, FollowsAnAnswerUntilItEnds) {
  auto request = serve("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n\r\n" +
                       std::string(10000, 'x') + "end");
  const Interruption interruption;
  std::string taken;
  const auto take = [&](std::string_view piece) {
    taken += piece;
    return true;
  };
  EXPECT_EQ(follow_control(path_, "/api/v1/events", interruption, take),
            "mbgated has ended, or sends no more (journalctl -u mbgated)");
  EXPECT_EQ(taken, std::string(10000, 'x') + "end");
  EXPECT_TRUE(request.get().starts_with("GET /api/v1/events HTTP/1.1\r\n"));
}

TEST_F(ControlShell, FollowsNothingThatWasRefused) {
  const auto request = serve(
      "HTTP/1.1 503 Service Unavailable\r\nContent-Length: 20\r\n\r\n{\"error\":\"too many\"}");
  const Interruption interruption;
  const auto take = [](std::string_view /*piece*/) { return true; };
  EXPECT_EQ(follow_control(path_, "/api/v1/events", interruption, take), "too many");
}

TEST_F(ControlShell, FollowsNoLongerThanWanted) {
  const auto request = serve("HTTP/1.1 200 OK\r\n\r\nfirst");
  const Interruption interruption;
  const auto take = [](std::string_view /*piece*/) { return false; };
  EXPECT_EQ(follow_control(path_, "/api/v1/events", interruption, take), "");
}

}  // namespace
}  // namespace mbgate::ctl
