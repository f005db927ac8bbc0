// SPDX-License-Identifier: Apache-2.0
#include "io/denials/attempts.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <boost/asio/io_context.hpp>
#include <cerrno>

#include "unit/io/clients/socket_pair.hpp"

namespace mbgate::io {
namespace {

TEST(Attempts, MakeASocketOfAFamilyThatThereIs) {
  EXPECT_EQ(try_socket(AF_INET), 0);
  EXPECT_EQ(try_socket(AF_MAX), EAFNOSUPPORT);
}

// 192.0.2.0/24 is for documentation (RFC 5737): no machine has it.
TEST(Attempts, BindAnAddressThatIsNotThereYet) {
  gateway::ListenerSettings listener;
  listener.address = "192.0.2.77";
  listener.port = 0;
  EXPECT_EQ(try_bind(listener), 0);
}

TEST(Attempts, SeeThatAPortIsTakenAndLeaveAFreeOneFree) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  std::optional first(bind_listener(context, listener));
  ASSERT_TRUE(first->has_value()) << first->error().why;
  listener.port = (*first)->local_endpoint().port();
  EXPECT_EQ(try_bind(listener), EADDRINUSE);
  first.reset();
  EXPECT_EQ(try_bind(listener), 0);
  EXPECT_TRUE(bind_listener(context, listener).has_value());
}

TEST(Attempts, LookAtAFolderWithoutMakingAnything) {
  EXPECT_EQ(try_folder("/dev/null"), EACCES);  // nobody may enter it, not even root
  EXPECT_EQ(try_folder("/no/such/folder"), ENOENT);
  EXPECT_EQ(try_folder(testing::TempDir()), 0);
}

}  // namespace
}  // namespace mbgate::io
