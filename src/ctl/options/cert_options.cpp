// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/cert_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

#include "ctl/cert/certificate.hpp"
#include "ctl/cert/role_extension.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kMostDays = 36'500;
constexpr std::size_t kLongestName = 64;  // of a common name (RFC 5280)

void add_folder(CLI::App& command, std::filesystem::path& folder) {
  command.add_option("--directory", folder, "where the authority's files are, and new ones go")
      ->type_name("DIR")
      ->capture_default_str();
}

void add_days(CLI::App& command, unsigned& days, const std::string& what) {
  command.add_option("--days", days, what)->check(CLI::Range(1U, kMostDays))->capture_default_str();
}

void add_making(CLI::App& command, NewCertificate& make) {
  add_folder(command, make.folder);
  add_days(command, make.days, "that it is valid");
  command.add_option("--rsa", make.rsa_bits, "an RSA key of so many bits; default: ECDSA on P-256")
      ->type_name("BITS")
      ->check(CLI::IsMember(std::vector<unsigned>{2048, 3072, 4096}));
  command.add_flag("--force", make.replace, "replace files that are there, keys too");
}

/// The name of a certificate is that of its files too.
std::string wrong_name(const std::string& name) {
  const auto is_allowed = [](unsigned char it) {
    return std::isalnum(it) != 0 || it == '-' || it == '.' || it == '_';
  };
  if (name.empty() || name.size() > kLongestName || name.front() == '.' ||
      !std::ranges::all_of(name, is_allowed)) {
    return "\"" + name +
           "\" names no certificate: it is letters, digits, '-', '.' and '_', at "
           "most " +
           std::to_string(kLongestName) + ", such as gateway or hmi-1";
  }
  return name == "ca" ? "\"ca\" is the authority's own name: choose another" : std::string();
}

}  // namespace

CertOptions::CertOptions(CLI::App& app)
    : cert_(app.add_subcommand(
          "cert", "Make, revoke and show the certificates of gateways and clients (TLS).")),
      make_authority_(cert_->add_subcommand(
          "ca", "Make an authority: its key, its certificate and a list of revoked ones.")),
      make_server_(cert_->add_subcommand("server", "Make a key and a certificate for a gateway.")),
      make_client_(cert_->add_subcommand("client", "Make a key and a certificate for a client.")),
      revoke_(cert_->add_subcommand("revoke", "Put a certificate on the list of revoked ones.")),
      renew_(cert_->add_subcommand("crl", "Sign the list of revoked certificates anew.")),
      show_(cert_->add_subcommand("show", "Say what is in a certificate or a list.")) {
  cert_->require_subcommand(1);
  authority_words_.make.name = "mbgate plant authority";
  authority_words_.make.days = kAuthorityDays;
  make_authority_->add_option("--name", authority_words_.make.name, "of the authority")
      ->capture_default_str();
  add_making(*make_authority_, authority_words_.make);

  make_server_->add_option("name", server_words_.make.name, "of the gateway, and of its files")
      ->required();
  make_server_
      ->add_option("--address", server_words_.addresses,
                   "by which clients reach it: an IP address or a host name; as often as needed")
      ->type_name("ADDRESS")
      ->required();
  add_making(*make_server_, server_words_.make);

  make_client_->add_option("name", client_words_.make.name, "of the client, and of its files")
      ->required();
  make_client_->add_option("--role", client_words_.role,
                           "what rules know it by; default: none, the NULL role");
  add_making(*make_client_, client_words_.make);

  revoke_->add_option("file", revoke_words_.file, "the certificate")->required();
  add_folder(*revoke_, revoke_words_.folder);
  add_days(*revoke_, revoke_words_.days, "until the list must be renewed");

  add_folder(*renew_, renew_words_.folder);
  add_days(*renew_, renew_words_.days, "until it must be renewed");
  renew_->add_flag("--force", renew_words_.replace, "begin an empty list: nobody is revoked");

  show_->add_option("file", show_words_.file, "certificates or a list, in PEM")->required();
}

bool CertOptions::given() const { return cert_->parsed(); }

Result<Command, std::string> CertOptions::server() const {
  if (auto why = wrong_name(server_words_.make.name); !why.empty()) {
    return why;
  }
  for (const auto& address : server_words_.addresses) {
    if (!is_numeric_address(address) && !is_host_name(address)) {
      return "\"" + address + "\" is neither an IP address nor a host name";
    }
  }
  return Command(CertCommand(server_words_));
}

Result<Command, std::string> CertOptions::client() const {
  if (auto why = wrong_name(client_words_.make.name); !why.empty()) {
    return why;
  }
  if (client_words_.role) {
    if (auto why = wrong_role(*client_words_.role); !why.empty()) {
      return why;
    }
  }
  return Command(CertCommand(client_words_));
}

Result<Command, std::string> CertOptions::command() const {
  if (make_server_->parsed()) {
    return server();
  }
  if (make_client_->parsed()) {
    return client();
  }
  if (make_authority_->parsed()) {
    const auto size = authority_words_.make.name.size();
    if (size == 0 || size > kLongestName) {
      return "the name of an authority has 1 to " + std::to_string(kLongestName) + " bytes";
    }
    return Command(CertCommand(authority_words_));
  }
  if (revoke_->parsed()) {
    return Command(CertCommand(revoke_words_));
  }
  return renew_->parsed() ? Command(CertCommand(renew_words_)) : Command(CertCommand(show_words_));
}

}  // namespace mbgate::ctl
