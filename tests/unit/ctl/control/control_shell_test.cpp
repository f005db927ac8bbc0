// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <sstream>

#include "ctl/control/connection_shell.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::chrono::seconds kAnswerLimit{60};

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
  const auto answer = ask_control(path_, "GET", "/healthz", kAnswerLimit);
  ASSERT_TRUE(answer) << answer.error();
  EXPECT_EQ(answer->status, 200U);
  EXPECT_EQ(answer->json.at("status").as_string(), "ok");
}

TEST_F(ControlShell, TakesALongAnswer) {
  const std::string json = R"({"status":")" + std::string(9'000'000, 'x') + "\"}";
  const auto request = serve("HTTP/1.1 200 OK\r\nContent-Length: " + std::to_string(json.size()) +
                             "\r\n\r\n" + json);
  EXPECT_TRUE(ask_control(path_, "GET", "/api/v1/status", kAnswerLimit));
}

TEST_F(ControlShell, SaysWhatIsNotASocket) {
  const auto file = folder_ / "file";
  std::ofstream(file) << "text";
  EXPECT_EQ(ask_control(file, "GET", "/healthz", kAnswerLimit).error(),
            file.string() + ": this is not a socket");
}

TEST_F(ControlShell, ReloadsAlsoWhereMessagesAreNoTexts) {
  const auto request = serve("HTTP/1.1 200 OK\r\nContent-Length: 16\r\n\r\n{\"messages\":[1]}");
  std::ostringstream out;
  std::ostringstream errors;
  EXPECT_EQ(run(ReloadCommand{path_}, out, errors), kExitDone);
  EXPECT_EQ(out.str(), "a message of another version\n");
}

TEST_F(ControlShell, SaysThatACommandMayStillBeDone) {
  const std::chrono::seconds none{0};
  EXPECT_EQ(ask_control(path_, "POST", "/api/v1/reload", none).error(),
            "mbgated has not answered within 0 s; it may still be done");
  EXPECT_EQ(ask_control(path_, "GET", "/api/v1/status", none).error(),
            "mbgated has not answered within 0 s");
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

/// A TCP port of this machine that somebody listens at.
class ControlShellOverTcp : public ControlShell {
 protected:
  void SetUp() override {
    ControlShell::SetUp();
    ::close(listener_);
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    ASSERT_EQ(::listen(listener_, 1), 0);
    ASSERT_EQ(::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    server_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }

  std::string server_;
};

TEST_F(ControlShellOverTcp, CallsTheOtherEndByItsAddress) {
  auto request = serve("HTTP/1.1 200 OK\r\nContent-Length: 15\r\n\r\n{\"status\":\"ok\"}");
  const auto answer = ask_control("tcp://" + server_, "GET", "/healthz", kAnswerLimit);
  ASSERT_TRUE(answer) << answer.error();
  EXPECT_EQ(answer->status, 200U);
  EXPECT_NE(request.get().find("\r\nHost: " + server_ + "\r\n"), std::string::npos);
}

TEST_F(ControlShellOverTcp, SaysThatNobodyListens) {
  ::close(listener_);
  listener_ = -1;
  EXPECT_EQ(ask_control("tcp://" + server_, "GET", "/healthz", kAnswerLimit).error(),
            "no program listens at tcp://" + server_ +
                ": is mbgated running, and is this one of its [http] listen?");
}

TEST(ControlPlace, OfTcpHasAHostAndAPort) {
  for (const std::string place :
       {"tcp://", "tcp://gateway", "tcp://:8080", "tcp://gateway:", "tcp://gateway:0",
        "tcp://gateway:65536", "tcp://::1:8080", "tcp://[::1]", "tcp://[gateway]:8080",
        "tcp://gateway:8080/", "tcp://me@gateway:8080"}) {
    EXPECT_EQ(
        wrong_place(place),
        place + ": expected a host and a port, such as tcp://127.0.0.1:8080 or tcp://[::1]:8080");
  }
}

}  // namespace
}  // namespace mbgate::ctl
