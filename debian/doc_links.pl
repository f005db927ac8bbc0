#!/usr/bin/perl
# SPDX-License-Identifier: Apache-2.0
# usage: doc_links.pl PACKAGE
#
# The documents below the folder PACKAGE link to files of the sources. What is in the package is linked to where it is
# there; of the others the words stay, without a link.
use strict;
use warnings;
use File::Basename qw(dirname);
use File::Spec;

my $package = shift // die "usage: doc_links.pl PACKAGE\n";
my $doc = '/usr/share/doc/mbgate';

# Where files and folders of the sources are in the package.
my %place = (
  'CHANGELOG.md' => "$doc/CHANGELOG.md",
  'LICENSE' => "$doc/copyright",
  'README.md' => "$doc/README.md",
  'SECURITY.md' => "$doc/SECURITY.md",
  'bench' => "$doc/bench",
  'conf/demo.toml' => "$doc/examples/demo.toml",
  'conf/demo-sim.toml' => "$doc/examples/demo-sim.toml",
  'conf/grafana' => "$doc/examples",
  'conf/mbgate.toml' => "$doc/mbgate.toml",
  'conf/profiles' => '/usr/share/mbgate/profiles',
  'conf/profiles/README.md' => "$doc/profiles/README.md",
  'conf/prometheus' => "$doc/examples",
  'docs' => "$doc/docs",
  'examples' => "$doc/examples",
  'systemd' => "$doc/examples",
);

# The place of a path of the sources; undef if it is not in the package.
sub place_of {
  my ($path) = @_;
  for (my $front = $path; $front ne '.'; $front = dirname($front)) {
    next unless exists $place{$front};
    my $found = $place{$front} . substr($path, length $front);
    return -e "$package$found" ? $found : undef;
  }
  return undef;
}

# What a link of the document `source` at `installed` becomes.
sub link_of {
  my ($mark, $words, $target, $source, $installed) = @_;
  return "$mark\[$words]($target)" if $target =~ /^(#|\w+:)/;
  my ($path, $fragment) = $target =~ /^([^#]*)(.*)$/;
  # Step by step: the folders of the sources are not there to be asked.
  my @parts;
  for my $part (split m{/}, dirname($source) . "/$path") {
    $part eq '..' ? pop @parts : $part ne '.' && $part ne '' && push @parts, $part;
  }
  my $found = place_of(join '/', @parts) // return $words;
  my $relative = $found =~ m{^\Q$doc\E/} ? File::Spec->abs2rel($found, dirname($installed)) : $found;
  return "$mark\[$words]($relative$fragment)";
}

for my $front (sort keys %place) {
  my @documents = grep { /\.md$/ } split /\n/, qx(cd "$package" && find ".$place{$front}" -type f 2>/dev/null);
  for my $file (@documents) {
    my $installed = substr $file, 1;
    my $source = $front . substr $installed, length $place{$front};
    open my $in, '<', "$package$installed" or die "$installed: $!\n";
    my $text = do { local $/; <$in> };
    close $in;
    $text =~ s/(!?)\[([^\]]*)\]\(([^)\s]+)\)/link_of($1, $2, $3, $source, $installed)/ge;
    open my $out, '>', "$package$installed" or die "$installed: $!\n";
    print $out $text;
    close $out or die "$installed: $!\n";
  }
}
