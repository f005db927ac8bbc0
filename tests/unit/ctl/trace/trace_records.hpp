// SPDX-License-Identifier: Apache-2.0
// Records of a trace as mbgated sends them, for tests.
#pragma once

#include <string>

namespace mbgate::ctl {

/// A read by 192.0.2.7 that was answered after 6.0 ms. `wire`: the frames for it.
inline std::string read_record(const std::string& wire) {
  return R"({"failed":false,"client":{"address":"192.0.2.7","connection":3,"listener":"plant"},)"
         R"("request":{"at":"2026-11-24T22:10:00.123456Z","bytes":"00 07 00 00 00 06 01 03 00 1E 00 02",)"
         R"("text":"transaction 7 unit 1: read holding registers 30..31"},)"
         R"("answer":{"at":"2026-11-24T22:10:00.129456Z","bytes":"00 07 00 00 00 07 01 03 04 00 03 0D 40",)"
         R"("text":"transaction 7 unit 1: 2 registers: 0x0003 0x0D40"},)"
         R"("refused":false,"ended":"answered","wire":[)" +
         wire + R"(],"wire_not_kept":0})";
}

/// The same read, answered with exception 0B.
inline std::string failed_record(const std::string& wire) {
  return R"({"failed":true,"client":{"address":"192.0.2.7","connection":3,"listener":"plant"},)"
         R"("request":{"at":"2026-11-24T22:10:00.123456Z","bytes":"00 07 00 00 00 06 01 03 00 1E 00 02",)"
         R"("text":"transaction 7 unit 1: read holding registers 30..31"},)"
         R"("answer":{"at":"2026-11-24T22:10:00.424456Z","bytes":"00 07 00 00 00 03 01 83 0B",)"
         R"("text":"transaction 7 unit 1: exception 0x0B"},)"
         R"("refused":false,"ended":"no valid answer came","wire":[)" +
         wire + R"(],"wire_not_kept":0})";
}

/// A frame on line-a. `rest`: try, shared_by, outcome, ended_at, heard, heard_text, response.
inline std::string sent_frame(const std::string& rest) {
  return R"({"bus":"line-a","device":"axis-x","address":1,"framing":"rtu",)"
         R"("sent":{"at":"2026-11-24T22:10:00.123556Z","bytes":"01 03 00 1E 00 02 A4 0D",)"
         R"("text":"unit 1: read holding registers 30..31"},"heard_not_kept":0,)" +
         rest + "}";
}

inline std::string good_frame() {
  return sent_frame(
      R"("try":1,"shared_by":1,"outcome":"answered","ended_at":"2026-11-24T22:10:00.129400Z",)"
      R"("heard":[{"at":"2026-11-24T22:10:00.128656Z","bytes":"01 03 04 00 03 0D 40 0F 53"}],)"
      R"("heard_text":"2 registers: 0x0003 0x0D40","response":"03 04 00 03 0D 40")");
}

inline std::string damaged_frame() {
  return sent_frame(
      R"("try":2,"shared_by":3,"outcome":"damaged","ended_at":"2026-11-24T22:10:00.423556Z",)"
      R"("heard":[{"at":"2026-11-24T22:10:00.128656Z","bytes":"01 03 04 00 03 0D 40 FF FF"}],)"
      R"("heard_text":"CRC FF FF, 0F 53 would be right","response":null)");
}

inline std::string silent_frame() {
  return sent_frame(
      R"("try":1,"shared_by":1,"outcome":"no response","ended_at":"2026-11-24T22:10:00.423556Z",)"
      R"("heard":[],"heard_text":"nothing","response":null)");
}

}  // namespace mbgate::ctl
