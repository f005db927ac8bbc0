// SPDX-License-Identifier: Apache-2.0
#include "app/systemd.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace mbgate::app {
namespace {

/// Stands in for systemd's end of the notification socket.
class SystemdTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ =
        std::filesystem::temp_directory_path() / ("mbgate-notify-" + std::to_string(::getpid()));
    std::filesystem::remove(path_);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string text = path_.string();
    ASSERT_LT(text.size(), sizeof address.sun_path);
    std::memcpy(static_cast<void*>(address.sun_path), text.data(), text.size());
    ASSERT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", text.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("NOTIFY_SOCKET");
    std::filesystem::remove(path_);
  }
  std::string notified() {
    std::array<char, 512> buffer{};
    const ssize_t count = ::recv(socket_.get(), buffer.data(), buffer.size(), 0);
    return count > 0 ? std::string(buffer.data(), static_cast<std::size_t>(count)) : std::string();
  }

  std::filesystem::path path_;
  sys::UniqueFd socket_{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
};

TEST_F(SystemdTest, HearsThatTheServiceIsReady) {
  notify_ready("2 listeners");
  EXPECT_EQ(notified(), "READY=1\nSTATUS=2 listeners");
}

TEST_F(SystemdTest, HearsTheStatus) {
  notify_status("3 clients");
  EXPECT_EQ(notified(), "STATUS=3 clients");
}

// systemd compares the time with its own clock, to know that READY=1 is of this reload.
TEST_F(SystemdTest, HearsThatTheServiceReloads) {
  notify_reloading();
  EXPECT_THAT(notified(), testing::MatchesRegex("RELOADING=1\nMONOTONIC_USEC=[0-9]+\n"
                                                "STATUS=reading the configuration"));
}

TEST_F(SystemdTest, HearsThatTheServiceStops) {
  notify_stopping();
  EXPECT_EQ(notified(), "STOPPING=1\nSTATUS=stopping");
}

TEST_F(SystemdTest, HearsThatTheServiceIsAlive) {
  notify_alive();
  EXPECT_EQ(notified(), "WATCHDOG=1");
}

TEST_F(SystemdTest, HearsWhichSocketsItShallKeep) {
  EXPECT_TRUE(store_socket("stored/plant/127.0.0.1%3A502", socket_.get()));
  EXPECT_EQ(notified(), "FDSTORE=1\nFDNAME=stored/plant/127.0.0.1%3A502");
  remove_stored_socket("stored/plant/127.0.0.1%3A502");
  EXPECT_EQ(notified(), "FDSTOREREMOVE=1\nFDNAME=stored/plant/127.0.0.1%3A502");
}

// Its socket takes as many as net.unix.max_dgram_qlen says. The last of these tests: what waits is
// dropped with the socket.
TEST_F(SystemdTest, IsNotWaitedForWhileItReadsNothing) {
  for (int times = 0; times < 10'000; ++times) {
    notify_status("nobody reads this");
  }
}

TEST(StoringSockets, IsInVainWithoutSystemd) {
  const sys::UniqueFd socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_FALSE(store_socket("plant", socket.get()));
}

TEST(WatchdogLimit, IsThatOfTheUnitIfItIsForThisProcess) {
  EXPECT_EQ(watchdog_limit(), std::nullopt);
  ::setenv("WATCHDOG_USEC", "30000000", 1);
  EXPECT_EQ(watchdog_limit(), std::chrono::seconds(30));
  ::setenv("WATCHDOG_PID", "1", 1);
  EXPECT_EQ(watchdog_limit(), std::nullopt);
  ::unsetenv("WATCHDOG_PID");
  ::unsetenv("WATCHDOG_USEC");
}

TEST(InheritedSockets, AreNoneWithoutSystemd) { EXPECT_TRUE(take_inherited_sockets().empty()); }

}  // namespace
}  // namespace mbgate::app
