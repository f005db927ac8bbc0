// SPDX-License-Identifier: Apache-2.0
#include "io/advice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

namespace mbgate::io {
namespace {

using testing::HasSubstr;

TEST(Advice, NamesTheSocketUnitAndTheDropInForALowPort) {
  EXPECT_EQ(listen_advice(502, EACCES),
            "; a port below 1024 needs the capability CAP_NET_BIND_SERVICE: let systemd open it "
            "(mbgated.socket), or give the service the drop-in port-502.conf");
  EXPECT_THAT(listen_advice(1502, EACCES), HasSubstr("SocketBindDeny="));
}

TEST(Advice, NamesTheDropInThatForbidsSockets) {
  EXPECT_THAT(listen_advice(502, EAFNOSUPPORT), HasSubstr("socket-only.conf"));
  EXPECT_THAT(connect_advice(EPERM), HasSubstr("socket-only.conf"));
  EXPECT_THAT(connect_advice(ENETUNREACH), HasSubstr("PrivateNetwork="));
}

TEST(Advice, IsEmptyWhereTheCauseIsNotCertain) {
  EXPECT_EQ(listen_advice(502, EADDRINUSE), "");
  EXPECT_EQ(connect_advice(ECONNREFUSED), "");
  EXPECT_EQ(folder_advice("/srv/plant", ENOENT, "choose a path below /run/mbgate"), "");
}

TEST(Advice, NamesTheFolderAndWhatTheServiceMayDo) {
  EXPECT_EQ(folder_advice("/srv/plant", EROFS, "choose a path below /run/mbgate"),
            "; the user that mbgated runs as must be able to write into /srv/plant (of the "
            "service: ReadWritePaths=), or choose a path below /run/mbgate");
}

TEST(Advice, TellsDenialsFromWhatMayPass) {
  EXPECT_TRUE(is_denial(EACCES));
  EXPECT_TRUE(is_denial(EAFNOSUPPORT));
  EXPECT_FALSE(is_denial(EMFILE));
  EXPECT_FALSE(is_denial(EADDRINUSE));
}

}  // namespace
}  // namespace mbgate::io
