// SPDX-License-Identifier: Apache-2.0
// What OpenSSL would be given to read, one record at a time. That clients are ended is shown with
// the program (tests/integration/tls_records_test.py).
#include "sys/tls_stream.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>

namespace mbgate::sys {
namespace {

using namespace std::chrono_literals;
using Turn = RecordGate::Turn;

class RecordGateTest : public testing::Test {
 protected:
  RecordGateTest() {
    SSL_set_bio(ssl_.get(), BIO_new(BIO_s_mem()), nullptr);
    gate_.watch(*ssl_);
  }

  void come(const std::string& bytes) {
    BIO_write(SSL_get_rbio(ssl_.get()), bytes.data(), static_cast<int>(bytes.size()));
  }

  /// How many bytes there are to read, by so many at a time as OpenSSL would.
  std::size_t read(std::size_t head, std::size_t rest) {
    std::array<char, 100> bytes{};
    std::size_t all = 0;
    int count = 1;
    for (std::size_t wanted = head; count > 0; wanted = rest) {
      count = BIO_read(SSL_get_rbio(ssl_.get()), bytes.data(), static_cast<int>(wanted));
      all += count > 0 ? static_cast<std::size_t>(count) : 0;
    }
    EXPECT_TRUE(BIO_should_read(SSL_get_rbio(ssl_.get())));
    return all;
  }

  ContextHandle context_{SSL_CTX_new(TLS_server_method())};
  RecordGate gate_;
  SslHandle ssl_{SSL_new(context_.get())};
};

const std::string kRecord(
    "\x17\x03\x03\x00\x04"
    "abcd",
    9);

TEST_F(RecordGateTest, ClosesBehindARecordUntilItIsOpened) {
  come(kRecord + kRecord);
  EXPECT_EQ(read(5, 4), 9U);
  EXPECT_EQ(gate_.turn(RecordGate::Instant{}), Turn::again);
  EXPECT_EQ(read(5, 4), 0U);
  gate_.open();
  EXPECT_EQ(read(5, 4), 9U);
}

TEST_F(RecordGateTest, WaitsForTheRestOfARecord) {
  come(kRecord.substr(0, 3));
  EXPECT_EQ(read(5, 4), 3U);
  EXPECT_EQ(gate_.turn(RecordGate::Instant{}), Turn::wait);
  gate_.open();
  come(kRecord.substr(3, 3));
  EXPECT_EQ(read(2, 4), 3U);
  EXPECT_EQ(gate_.turn(RecordGate::Instant{}), Turn::wait);
  gate_.open();
  come(kRecord.substr(6));
  EXPECT_EQ(read(3, 3), 3U);
  EXPECT_EQ(gate_.turn(RecordGate::Instant{}), Turn::again);
}

TEST_F(RecordGateTest, KnowsARecordThatIsEmptyAndOneOfSsl2) {
  come(std::string("\x17\x03\x03\x00\x00", 5));
  EXPECT_EQ(read(5, 5), 5U);
  gate_.open();
  come(std::string("\x80\x09\x01\x03\x01", 5) + "abcdef" + kRecord);
  EXPECT_EQ(read(5, 6), 11U);
  EXPECT_EQ(gate_.turn(RecordGate::Instant{}), Turn::again);
}

TEST_F(RecordGateTest, HasEnoughOfAHundredWithinASecond) {
  RecordGate::Instant at{};
  const auto pass = [this, &at] {
    gate_.open();
    come(kRecord);
    read(5, 4);
    return gate_.turn(at);
  };
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(pass(), Turn::again);
  }
  EXPECT_EQ(pass(), Turn::too_many);
  at += 1s;
  EXPECT_EQ(pass(), Turn::again);
}

}  // namespace
}  // namespace mbgate::sys
