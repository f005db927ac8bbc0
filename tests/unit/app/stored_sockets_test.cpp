// SPDX-License-Identifier: Apache-2.0
#include "app/stored_sockets.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>

#include "io/clients/listening_socket.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;
using testing::ElementsAre;
using testing::IsEmpty;

/// Stands in for systemd, which has a copy of each socket.
class StoredSocketsTest : public testing::Test {
 protected:
  StoredSockets make() {
    return StoredSockets(
        [this](const std::string& name, int socket) {
          kept_.push_back({name, copy_of(socket)});
          return has_systemd_;
        },
        [this](const std::string& name) {
          removed_.push_back(name);
          std::erase_if(kept_, [&](const InheritedSocket& it) { return it.name == name; });
        });
  }
  static sys::UniqueFd copy_of(int socket) {
    return sys::UniqueFd(::fcntl(socket, F_DUPFD_CLOEXEC, 0));
  }
  /// Binds a listener of its own address.
  tcp::acceptor bind(gateway::ListenerSettings& listener) {
    listener.address = "127.0.0.1";
    listener.port = 0;
    auto acceptor = *io::bind_listener(context_, listener);
    listener.port = acceptor.local_endpoint().port();
    return acceptor;
  }
  std::string name_of(const gateway::ListenerSettings& listener) {
    return "stored/" + listener.name + "/127.0.0.1%3A" + std::to_string(listener.port);
  }
  /// What systemd hands to the next process.
  std::vector<InheritedSocket> handed_over() {
    std::vector<InheritedSocket> sockets;
    sockets.reserve(kept_.size());
    for (const auto& [name, fd] : kept_) {
      sockets.push_back({name, copy_of(fd.get())});
    }
    return sockets;
  }
  bool can_be_bound(const gateway::ListenerSettings& listener) {
    return io::bind_listener(context_, listener).has_value();
  }
  static gateway::ListenerSettings listener(const std::string& name) {
    gateway::ListenerSettings settings;
    settings.name = name;
    return settings;
  }

  boost::asio::io_context context_;
  bool has_systemd_ = true;
  std::vector<InheritedSocket> kept_;
  std::vector<std::string> removed_;
};

TEST(StoredName, HasNothingThatSystemdDoesNotTake) {
  using boost::asio::ip::make_address;
  EXPECT_EQ(stored_name("plant", {make_address("127.0.0.1"), 502}), "stored/plant/127.0.0.1%3A502");
  EXPECT_EQ(stored_name("plant", {make_address("fd00::1"), 502}),
            "stored/plant/[fd00%3A%3A1]%3A502");
  EXPECT_EQ(stored_name("a%\n\xC3", {make_address("::"), 1}), "stored/a%25%0A%C3/[%3A%3A]%3A1");
}

TEST_F(StoredSocketsTest, AreClaimedByTheNextProcess) {
  auto plant = listener("plant");
  auto acceptor = bind(plant);
  auto first = make();
  first.keep(plant, acceptor);
  EXPECT_EQ(kept_.at(0).name, name_of(plant));
  first.let_go();
  auto sockets = handed_over();
  sockets.push_back({name_of(plant), copy_of(sockets[0].fd.get())});
  sockets.push_back({"office", sys::UniqueFd()});
  auto next = make();
  next.take(sockets, {plant});
  ASSERT_EQ(sockets.size(), 1U);
  EXPECT_EQ(sockets[0].name, "office");
  const auto claimed = next.claim(plant);
  EXPECT_TRUE(io::is_bound_for(plant, claimed.get()));
  EXPECT_FALSE(next.claim(plant).is_open());  // it has gone
  next.end_unclaimed();
  EXPECT_THAT(removed_, IsEmpty());
}

TEST_F(StoredSocketsTest, ThatNoListenerHasAreEndedBeforeOthersBind) {
  auto plant = listener("plant");
  auto office = listener("office");
  auto of_plant = bind(plant);
  auto of_office = bind(office);
  auto first = make();
  first.keep(plant, of_plant);
  first.keep(office, of_office);
  of_plant.close();
  of_office.close();
  first.let_go();
  auto moved = plant;
  moved.address = "127.0.0.2";
  auto gone = office;
  gone.is_gone = true;
  auto renamed = office;
  renamed.name = "lab";
  auto sockets = handed_over();
  EXPECT_FALSE(can_be_bound(plant));
  EXPECT_FALSE(can_be_bound(office));
  auto next = make();
  const auto copies = std::move(kept_);  // systemd has not read yet that it shall let them go
  next.take(sockets, {moved, gone, renamed});
  EXPECT_TRUE(can_be_bound(plant));
  EXPECT_TRUE(can_be_bound(office));
  EXPECT_THAT(removed_, ElementsAre(name_of(plant), name_of(office)));
  EXPECT_FALSE(next.claim(renamed).is_open());
}

TEST_F(StoredSocketsTest, OfAnotherAddressThanTheirNameSaysAreEnded) {
  auto plant = listener("plant");
  auto office = listener("office");
  auto of_plant = bind(plant);
  auto of_office = bind(office);
  std::vector<InheritedSocket> sockets;
  sockets.push_back({name_of(plant), copy_of(of_office.native_handle())});
  auto stored = make();
  stored.take(sockets, {plant, office});
  EXPECT_FALSE(stored.claim(plant).is_open());
  EXPECT_THAT(removed_, ElementsAre(name_of(plant)));
}

TEST_F(StoredSocketsTest, EndWithTheirListenerThoughSystemdHasACopy) {
  auto plant = listener("plant");
  auto acceptor = bind(plant);
  auto stored = make();
  stored.keep(plant, acceptor);
  const auto copies = std::move(kept_);
  acceptor.close();
  EXPECT_FALSE(can_be_bound(plant));
  stored.end(plant);
  EXPECT_THAT(removed_, ElementsAre(name_of(plant)));
  EXPECT_TRUE(can_be_bound(plant));
  stored.end(plant);
  EXPECT_EQ(removed_.size(), 1U);  // there is none any more
}

TEST_F(StoredSocketsTest, ThatNobodyClaimsAreEnded) {
  auto plant = listener("plant");
  auto acceptor = bind(plant);
  std::vector<InheritedSocket> sockets;
  sockets.push_back({name_of(plant), copy_of(acceptor.native_handle())});
  auto stored = make();
  stored.take(sockets, {plant});
  stored.end_unclaimed();
  EXPECT_THAT(removed_, ElementsAre(name_of(plant)));
  EXPECT_FALSE(stored.claim(plant).is_open());
}

TEST_F(StoredSocketsTest, AreNoneWhereTheKernelChoosesThePort) {
  auto plant = listener("plant");
  auto acceptor = bind(plant);
  plant.port = 0;
  auto stored = make();
  stored.keep(plant, acceptor);
  EXPECT_TRUE(kept_.empty());
}

// Clients that connect while it ends are refused then, and do not wait for nobody.
TEST_F(StoredSocketsTest, AreNoneWithoutSystemd) {
  has_systemd_ = false;
  auto plant = listener("plant");
  auto acceptor = bind(plant);
  auto stored = make();
  stored.keep(plant, acceptor);
  kept_.clear();
  acceptor.close();
  EXPECT_TRUE(can_be_bound(plant));
}

}  // namespace
}  // namespace mbgate::app
