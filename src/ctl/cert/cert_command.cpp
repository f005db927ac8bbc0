// SPDX-License-Identifier: Apache-2.0
#include "ctl/cert/cert_command.hpp"

#include <openssl/x509v3.h>

#include <ostream>

#include "ctl/cert/cert_text.hpp"
#include "ctl/cert/pem_file.hpp"
#include "ctl/cert/revocation_list.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

namespace fs = std::filesystem;

/// What was done and is to be done with it; or, with another status, why it was not.
struct Outcome {
  int status;
  std::string text;
};

Outcome done(std::string text) { return {kExitDone, std::move(text)}; }
Outcome refused(std::string why) { return {kExitNotDone, std::move(why)}; }

Seconds current_time() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

/// A certificate that outlives its authority would fail one day without being expired itself.
std::string outlives(const Authority& authority, const NewCertificate& make) {
  const auto end = time_of(*X509_get0_notAfter(authority.certificate.get()));
  const auto left = std::chrono::duration_cast<std::chrono::days>(end - current_time()).count();
  if (left >= static_cast<long>(make.days)) {
    return {};
  }
  return "the authority ends on " + time_text(end) + ", before the certificate would: " +
         (left < 1 ? "make a new one (mbgatectl cert ca)"
                   : "give --days " + std::to_string(left) + " or less");
}

/// Why that was not done, or nothing.
std::string make_signed(const NewCertificate& make, CertificateContent content) {
  const auto authority = read_authority(make.folder);
  if (!authority) {
    return authority.error();
  }
  if (auto why = outlives(*authority, make); !why.empty()) {
    return why;
  }
  content.name = make.name;
  content.days = make.days;
  const auto key = make_key(make.rsa_bits);
  const auto certificate = make_certificate(content, *key, &*authority);
  // Whoever shows a certificate shows those up to the root with it (MB-TCP-Security, R-46).
  const std::string chain = to_pem(*certificate) + to_pem(*authority->certificate);
  return write_files({{make.folder / (make.name + ".key"), to_pem(*key), true},
                      {make.folder / (make.name + ".crt"), chain}},
                     make.replace);
}

template <typename Made>
Outcome with_advice(std::string why, const Made& made) {
  return why.empty() ? done(advice_after(made)) : refused(std::move(why));
}

Outcome carry_out_one(const MakeAuthority& command) {
  const auto& make = command.make;
  const auto key = make_key(make.rsa_bits);
  Authority authority{
      make_certificate({Purpose::authority, make.name, make.days, {}, {}}, *key, nullptr), {}};
  openssl::expect(EVP_PKEY_up_ref(key.get()));
  authority.key.reset(key.get());
  const auto list = next_list(authority, nullptr, kListDays);
  auto why = write_files({{make.folder / "ca.key", to_pem(*key), true},
                          {make.folder / "ca.crt", to_pem(*authority.certificate)},
                          {make.folder / "ca.crl", to_pem(*list)}},
                         make.replace);
  return with_advice(std::move(why), command);
}

Outcome carry_out_one(const MakeServer& command) {
  return with_advice(make_signed(command.make, {Purpose::server, {}, 1, command.addresses, {}}),
                     command);
}

Outcome carry_out_one(const MakeClient& command) {
  return with_advice(make_signed(command.make, {Purpose::client, {}, 1, {}, command.role}),
                     command);
}

/// The list of a folder, of which its authority is known to have signed it.
Result<openssl::RevocationList, std::string> own_list(const fs::path& folder,
                                                      const Authority& authority) {
  auto list = read_list(folder / "ca.crl");
  if (!list) {
    return list.error() + " (mbgatectl cert crl --force makes an empty one)";
  }
  if (!is_list_of(**list, authority)) {
    return (folder / "ca.crl").string() + " was not signed by " + (folder / "ca.key").string();
  }
  return *std::move(list);
}

Outcome write_list(const fs::path& folder, X509_CRL& list, const std::string& what) {
  if (auto why = write_files({{folder / "ca.crl", to_pem(list)}}, true); !why.empty()) {
    return refused(std::move(why));
  }
  return done(what + " " + (folder / "ca.crl").string() + " has " +
              std::to_string(revoked_count(list)) + " and must be renewed before " +
              time_text(time_of(*X509_CRL_get0_nextUpdate(&list))) + ".\n" +
              advice_after_list(folder));
}

Outcome carry_out_one(const Revoke& command) {
  const auto authority = read_authority(command.folder);
  if (!authority) {
    return refused(authority.error());
  }
  const auto certificates = read_certificates(command.file);
  if (!certificates) {
    return refused(certificates.error());
  }
  X509& certificate = *certificates->front();
  const std::string file = command.file.string();
  if (X509_verify(&certificate, authority->key.get()) != 1) {
    static_cast<void>(openssl::last_error());
    return refused(file + " was not signed by " + (command.folder / "ca.key").string() +
                   ": only its own authority can revoke it");
  }
  if (X509_check_ca(&certificate) != 0) {
    return refused(file +
                   " is the authority itself, which no list of its own can revoke: make a "
                   "new one, and new certificates");
  }
  const auto old = own_list(command.folder, *authority);
  if (!old) {
    return refused(old.error());
  }
  if (const auto since = revoked_at(**old, certificate)) {
    return refused(file + " has been revoked since " + time_text(*since));
  }
  const auto list = next_list(*authority, old->get(), command.days);
  revoke(*list, certificate, *authority);
  return write_list(command.folder, *list,
                    "Revoked " + name_text(*X509_get_subject_name(&certificate)) + ".");
}

Outcome carry_out_one(const RenewList& command) {
  const auto authority = read_authority(command.folder);
  if (!authority) {
    return refused(authority.error());
  }
  if (command.replace) {
    return write_list(command.folder, *next_list(*authority, nullptr, command.days),
                      "Made a list that is empty.");
  }
  const auto old = own_list(command.folder, *authority);
  if (!old) {
    return refused(old.error());
  }
  return write_list(command.folder, *next_list(*authority, old->get(), command.days),
                    "Renewed the list.");
}

Outcome carry_out_one(const ShowCertificate& command) {
  if (const auto list = read_list(command.file)) {
    return done(command.file.string() + "\n" + describe(**list, current_time()));
  }
  const auto certificates = read_certificates(command.file);
  if (!certificates) {
    return refused(certificates.error());
  }
  std::string text;
  for (const auto& certificate : *certificates) {
    text += command.file.string() + "\n" + describe(*certificate, current_time());
  }
  return done(std::move(text));
}

}  // namespace

int carry_out_cert(const CertCommand& command, std::ostream& out, std::ostream& errors) {
  Outcome outcome{};
  try {
    outcome = std::visit([](const auto& one) { return carry_out_one(one); }, command);
  } catch (const openssl::Failure& failure) {
    outcome = refused(failure.what());
  }
  if (outcome.status == kExitDone) {
    out << outcome.text;
  } else {
    errors << "mbgatectl: " << outcome.text << '\n';
  }
  return outcome.status;
}

}  // namespace mbgate::ctl
