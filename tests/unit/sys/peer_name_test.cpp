// SPDX-License-Identifier: Apache-2.0
// Which name a server must have. That a server is trusted, or not, is shown with one
// (tests/integration/tls_bus_test.py).
#include <gtest/gtest.h>
#include <openssl/x509_vfy.h>

#include "sys/tls_stream.hpp"

namespace mbgate::sys {
namespace {

/// The name that will be checked; "none": it is no name.
std::string checked_name(const std::string& name) {
  const ContextHandle context = client_context();
  const SslHandle ssl(SSL_new(context.get()));
  if (!expect_name(*ssl, name)) {
    return "none";
  }
  X509_VERIFY_PARAM* const wanted = SSL_get0_param(ssl.get());
  const char* const host = X509_VERIFY_PARAM_get0_host(wanted, 0);
  char* const address = X509_VERIFY_PARAM_get1_ip_asc(wanted);
  std::string text = host != nullptr ? host : address != nullptr ? address : "anybody";
  OPENSSL_free(address);
  return text;
}

TEST(PeerName, IsCheckedWhateverItIs) {
  EXPECT_EQ(checked_name("gw.plant"), "gw.plant");
  EXPECT_EQ(checked_name("192.0.2.7"), "192.0.2.7");
}

TEST(PeerName, IsNotLeftUncheckedWhereItCannotBe) {
  using namespace std::string_literals;
  for (const std::string& name :
       {""s, "\0"s, "gw\0.plant"s, "gw.plant\0"s, "192.0.2.7\0.evil"s, std::string(300, 'a')}) {
    EXPECT_EQ(checked_name(name), "none");
  }
}

}  // namespace
}  // namespace mbgate::sys
