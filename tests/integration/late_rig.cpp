// SPDX-License-Identifier: Apache-2.0
#include "integration/late_rig.hpp"

namespace mbgate::test {

bool LateRig::is_promised(int line, const ByteString& got) const {
  const auto now = ScriptedDevices::Clock::now();
  const auto& asked = asked_[static_cast<std::size_t>(line)];
  if (got.size() < 11) {
    return true;
  }
  const auto its = asked.find(unsigned{got[9]} << 8U | got[10]);  // registers hold their address
  return its == asked.end() || now <= its->second + kResponseTimeout + quarantine_;
}

void LateRig::judge(int line, const std::optional<ByteString>& got, const Expected& expected,
                    int& exceptions, Tally& tally) {
  const auto& [asked, transaction] = expected;
  if (!got) {
    ++tally.missing;
  } else if (*got == asked.answer(transaction)) {
    ++tally.right;
  } else if (got->size() == 9 && (*got)[7] == 0x83) {
    ++exceptions;
  } else if (is_promised(line, *got)) {
    ++tally.wrong;
  } else {
    ++tally.too_late;
    forget(line, asked);
  }
}

void LateRig::start(std::chrono::milliseconds quarantine, const std::string& bus,
                    const std::string& gateway, const std::vector<std::string>& arguments) {
  quarantine_ = quarantine;
  std::string text = gateway;
  for (int line = 0; line < kLateLines; ++line) {
    text += "[[listen]]\nname = \"" + name_of(line) + "\"\nport = 0\nbus = \"" + name_of(line) +
            "\"\n[[bus]]\nname = \"" + name_of(line) + "\"\ndevice = \"" + devices_.path(line) +
            "\"\nbaud = 115200\nparity = \"none\"\nlisten_first = \"0ms\"\n"
            "response_timeout = \"100ms\"\nretries = " +
            std::to_string(retries_of(line)) + "\n" + bus;
  }
  std::vector<std::string> all{"--config", folder_.write("mbgate.toml", text)};
  all.insert(all.end(), arguments.begin(), arguments.end());
  gateway_.emplace("mbgated", all, Process::Options{folder_.path(), {}});
}

Tally LateRig::run(int tries, const Attempt& attempt) {
  std::vector<std::uint16_t> ports;
  ports.reserve(kLateLines);
  for (int line = 0; line < kLateLines; ++line) {
    ports.push_back(gateway_->port_of(name_of(line)));
  }
  std::vector<Tally> tallies(kLateLines);
  std::vector<std::thread> threads;
  threads.reserve(kLateLines);
  for (int line = 0; line < kLateLines; ++line) {
    threads.emplace_back([line, tries, &attempt, port = ports[static_cast<std::size_t>(line)],
                          &tally = tallies[static_cast<std::size_t>(line)]] {
      TcpClient first(port);
      TcpClient second(port);
      for (int number = line; number < tries && !HasFailure(); number += kLateLines) {
        attempt(line, number, first, second, tally);
        ++tally.tries;
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  Tally all;
  for (int retries = 0; retries < 2; ++retries) {
    Tally half;
    for (int line = 0; line < kLateLines; ++line) {
      if (retries_of(line) == retries) {
        half.add(tallies[static_cast<std::size_t>(line)]);
      }
    }
    std::printf(
        "retries %d: %d tries, %d answers right, %d exceptions of the late read, %d of the "
        "other, %d missing, %d too late to tell, %d WRONG\n",
        retries, half.tries, half.right, half.exceptions, half.second_exceptions, half.missing,
        half.too_late, half.wrong);
    all.add(half);
  }
  return all;
}

}  // namespace mbgate::test
