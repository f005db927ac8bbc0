// SPDX-License-Identifier: Apache-2.0
#include "app/listeners.hpp"

#include <gtest/gtest.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <string_view>
#include <thread>

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;

/// An address for documentation (RFC 5737), which no machine has.
constexpr const char* kNobodys = "192.0.2.77";
constexpr ListenerWaits kFast{std::chrono::milliseconds(1), std::chrono::milliseconds(4)};

class ListenersTest : public testing::Test {
 protected:
  void SetUp() override {
    std::array<int, 2> ends{};
    ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK), 0);
    read_end_.reset(ends[0]);
    write_end_.reset(ends[1]);
    log_.emplace(false, write_end_.get());
  }
  std::string written() {
    log_->flush(std::chrono::seconds(60));
    std::string text(65536, '\0');
    const ssize_t count = ::read(read_end_.get(), text.data(), text.size());
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
  }
  Listeners::Take take() {
    return [this](gateway::ListenerId id, tcp::acceptor acceptor) {
      taken_.push_back({id, std::move(acceptor)});
    };
  }
  /// Fails as `failures_` say, one after the other, then binds on loopback.
  Listeners::Bind script() {
    return [this](boost::asio::io_context& context, const gateway::ListenerSettings& listener)
               -> Result<tcp::acceptor, io::ListenFailure> {
      if (listener.address == kNobodys && !failures_.empty()) {
        auto failure = failures_.front();
        failures_.pop_front();
        return failure;
      }
      auto reachable = listener;
      reachable.address = "127.0.0.1";
      return io::bind_listener(context, reachable);
    };
  }
  void run_until_taken(std::size_t count) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (taken_.size() < count && std::chrono::steady_clock::now() < limit) {
      context_.restart();
      context_.run_one_for(std::chrono::milliseconds(20));
    }
  }
  std::string address_of(std::size_t taken) const {
    return io::to_text(taken_[taken].acceptor.local_endpoint());
  }

  struct Taken {
    gateway::ListenerId id;
    tcp::acceptor acceptor;
  };
  boost::asio::io_context context_;
  sys::UniqueFd read_end_;
  sys::UniqueFd write_end_;
  std::optional<Log> log_;
  std::deque<io::ListenFailure> failures_;
  std::vector<Taken> taken_;
};

gateway::ListenerSettings listener_at(const std::string& name, const std::string& address) {
  gateway::ListenerSettings settings;
  settings.name = name;
  settings.address = address;
  settings.port = 0;
  return settings;
}

constexpr const char* kFirstLine =
    "warning: not there; it is tried again until this machine has the address (freebind = true "
    "listens at once)\n";

TEST_F(ListenersTest, TriesAnAddressThatIsNotThereAgainWhileOthersServe) {
  failures_ = {{"not there", true}, {"not there", true}, {"not there", true}};
  Listeners listeners(context_, *log_, take(), script(), kFast);
  ASSERT_TRUE(
      listeners.begin({listener_at("lan", kNobodys), listener_at("plant", "127.0.0.1")}, {}));
  EXPECT_EQ(taken_.size(), 1U);
  EXPECT_EQ(listeners.waiting(), 1U);
  EXPECT_EQ(written(), kFirstLine);
  listeners.start();
  EXPECT_EQ(written(), "listening plant " + address_of(0) + "\n");
  run_until_taken(2);
  ASSERT_EQ(taken_.size(), 2U);
  EXPECT_EQ(taken_[1].id, gateway::ListenerId{0});
  EXPECT_EQ(listeners.waiting(), 0U);
  EXPECT_EQ(written(), "listening lan " + address_of(1) + "\n");
}

TEST_F(ListenersTest, GoOnTryingWhenTheAddressComesWithSomebodyElseOnThePort) {
  failures_ = {{"not there", true}, {"in use", false}, {"in use", false}, {"not there", true}};
  Listeners listeners(context_, *log_, take(), script(), kFast);
  ASSERT_TRUE(listeners.begin({listener_at("lan", kNobodys)}, {}));
  listeners.start();
  run_until_taken(1);
  ASSERT_EQ(taken_.size(), 1U);
  EXPECT_EQ(written(), std::string(kFirstLine) +
                           "warning: in use; it is tried again\n"
                           "warning: not there; it is tried again\n"
                           "listening lan " +
                           address_of(0) + "\n");
}

TEST_F(ListenersTest, DoNotBeginWithAPortThatIsTaken) {
  failures_ = {{"in use", false}};
  Listeners listeners(context_, *log_, take(), script(), kFast);
  EXPECT_FALSE(
      listeners.begin({listener_at("lan", kNobodys), listener_at("plant", "127.0.0.1")}, {}));
  EXPECT_EQ(written(), "error: in use\n");
  EXPECT_FALSE(listeners.is_denied());
}

TEST_F(ListenersTest, TryNoMoreOnceStopped) {
  failures_ = {{"not there", true}};
  Listeners listeners(context_, *log_, take(), script(), kFast);
  ASSERT_TRUE(listeners.begin({listener_at("lan", kNobodys)}, {}));
  listeners.start();
  listeners.stop();
  context_.run();
  EXPECT_TRUE(taken_.empty());
  EXPECT_EQ(listeners.waiting(), 0U);
}

class ListenersReload : public ListenersTest {
 protected:
  using All = std::vector<gateway::ListenerSettings>;
  void SetUp() override {
    ListenersTest::SetUp();
    ASSERT_TRUE(listeners().begin(before_, inherited()));
    listeners().start();
    said_ = "listening plant " + address_of(0) + "\nlistening office " + address_of(1) + "\n";
  }
  virtual std::vector<InheritedSocket> inherited() { return {}; }
  Listeners& listeners() {
    if (!listeners_) {
      listeners_.emplace(context_, *log_, take(), script(), kFast);
    }
    return *listeners_;
  }
  bool reload(const All& next) {
    return listeners().reload(before_, next,
                              [this](gateway::ListenerId id) { dropped_.push_back(id); });
  }

  const All before_{listener_at("plant", "127.0.0.1"), listener_at("office", "127.0.0.1")};
  std::optional<Listeners> listeners_;
  std::string said_;
  std::vector<gateway::ListenerId> dropped_;
};

TEST_F(ListenersReload, LeavesWhatDidNotMoveAsItIs) {
  All next = before_;
  next[0].pipeline = 1;
  EXPECT_TRUE(reload(next));
  EXPECT_TRUE(dropped_.empty());
  EXPECT_EQ(taken_.size(), 2U);
  EXPECT_EQ(written(), said_);
}

TEST_F(ListenersReload, BindsWhatMovedAndWhatIsNewAndDropsWhatIsGone) {
  All next = before_;
  next[0].tcp.keepalive_probes = 9;
  next[1].is_gone = true;
  next.push_back(listener_at("lab", "127.0.0.1"));
  EXPECT_TRUE(reload(next));
  EXPECT_EQ(dropped_, (std::vector{gateway::ListenerId{0}, gateway::ListenerId{1}}));
  ASSERT_EQ(taken_.size(), 4U);
  EXPECT_EQ(taken_[2].id, gateway::ListenerId{0});
  EXPECT_EQ(taken_[3].id, gateway::ListenerId{2});
  EXPECT_EQ(written(),
            said_ + "listening plant " + address_of(2) + "\nlistening lab " + address_of(3) + "\n");
}

TEST_F(ListenersReload, IsRefusedWholeWhereOneCannotListen) {
  failures_ = {{"in use", false}};
  All next = before_;
  next[0].freebind = true;
  next.push_back(listener_at("lan", kNobodys));
  EXPECT_FALSE(reload(next));
  EXPECT_EQ(dropped_, std::vector{gateway::ListenerId{0}});
  ASSERT_EQ(taken_.size(), 3U);  // as it was before
  EXPECT_EQ(taken_[2].id, gateway::ListenerId{0});
  EXPECT_EQ(written(), said_ + "error: in use\nlistening plant " + address_of(2) + "\n");
}

TEST_F(ListenersReload, TriesAnAddressThatIsNotThereAgain) {
  failures_ = {{"not there", true}, {"not there", true}};
  All next = before_;
  next.push_back(listener_at("lan", kNobodys));
  EXPECT_TRUE(reload(next));
  EXPECT_EQ(listeners().waiting(), 1U);
  run_until_taken(3);
  ASSERT_EQ(taken_.size(), 3U);
  EXPECT_EQ(taken_[2].id, gateway::ListenerId{2});
}

/// "plant" has a socket from systemd, which another process holds too: nobody else can bind it.
class ListenersReloadInherited : public ListenersReload {
 protected:
  void SetUp() override {
    ListenersReload::SetUp();
    written();
  }
  std::vector<InheritedSocket> inherited() override {
    std::vector<InheritedSocket> sockets;
    sockets.push_back({"plant", sys::UniqueFd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))});
    EXPECT_EQ(::listen(sockets[0].fd.get(), 1), 0);
    return sockets;
  }
};

TEST_F(ListenersReloadInherited, KeepsSocketsFromSystemdIfItIsRefused) {
  failures_ = {{"in use", false}};
  All next = before_;
  next[0].is_gone = true;
  next.push_back(listener_at("lan", kNobodys));
  EXPECT_FALSE(reload(next));
  EXPECT_TRUE(dropped_.empty());
  EXPECT_EQ(taken_.size(), 2U);
  EXPECT_EQ(listeners().waiting(), 0U);
  EXPECT_EQ(written(), "error: in use\n");
}

TEST_F(ListenersReloadInherited, HasNoneForAListenerThatComesBack) {
  All gone = before_;
  gone[0].is_gone = true;
  EXPECT_TRUE(reload(gone));
  EXPECT_EQ(dropped_, std::vector{gateway::ListenerId{0}});
  EXPECT_TRUE(listeners().reload(gone, before_, [](gateway::ListenerId) {}));
  All moved = before_;
  moved[0].freebind = true;
  dropped_.clear();
  EXPECT_TRUE(reload(moved));
  EXPECT_EQ(dropped_, std::vector{gateway::ListenerId{0}});  // its own socket is bound anew
}

bool give_address(std::string_view interface, const char* address) {
  const sys::UniqueFd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  std::ranges::copy(interface, request.ifr_name);
  sockaddr_in wanted{};
  wanted.sin_family = AF_INET;
  wanted.sin_addr.s_addr = htonl(boost::asio::ip::make_address_v4(address).to_uint());
  std::memcpy(&request.ifr_addr, &wanted, sizeof wanted);
  return ::ioctl(socket.get(), SIOCSIFADDR, &request) == 0;
}

/// A network of this thread's own, with nothing but loopback in it. Without any address the kernel
/// would take every address for its own.
bool leave_the_network() { return ::unshare(CLONE_NEWNET) == 0 && give_address("lo", "127.0.0.1"); }

TEST_F(ListenersTest, ListenAsSoonAsTheKernelHasTheAddress) {
  bool skipped = false;
  std::thread([&] {
    if (!leave_the_network()) {
      skipped = true;
      return;
    }
    Listeners listeners(context_, *log_, take(), io::bind_listener, kFast);
    EXPECT_TRUE(listeners.begin({listener_at("lan", kNobodys)}, {}));
    listeners.start();
    context_.run_for(std::chrono::milliseconds(20));
    EXPECT_TRUE(taken_.empty());
    EXPECT_TRUE(give_address("lo:1", kNobodys));
    run_until_taken(1);
    ASSERT_EQ(taken_.size(), 1U);
    EXPECT_EQ(taken_[0].acceptor.local_endpoint().address().to_string(), kNobodys);
  }).join();
  if (skipped) {
    GTEST_SKIP() << "skipped: may not make a network of its own";
  }
}

}  // namespace
}  // namespace mbgate::app
