# SPDX-License-Identifier: Apache-2.0
"""The disk of the virtual machine, its kernel and what starts it: Debian's packages, and nothing of this project but
the agent that runs what it is told."""

import os
import pathlib
import re
import shutil
import subprocess

HERE = pathlib.Path(__file__).parent
NEEDED = {
    "apt-get": "apt",
    "busybox": "busybox-static",
    "cpio": "cpio",
    "depmod": "kmod",
    "dpkg-deb": "dpkg",
    "mke2fs": "e2fsprogs",
    "mmdebstrap": "mmdebstrap",
    "modprobe": "kmod",
    "qemu-system-x86_64": "qemu-system-x86",
}
PACKAGES = ("systemd-sysv", "udev", "dbus", "iproute2", "kmod", "netbase", "perl-base", "procps", "util-linux")
BOOT_MODULES = ("virtio_pci", "virtio_blk", "ext4")
MODULES = ("virtio_console", "virtio_net", "vhci_hcd", "ftdi_sio", "cdc_acm", "8250_pci")
# What a Debian machine does by the clock, and what has no place in one that lives for two minutes.
MASKED = ("apt-daily.timer", "apt-daily-upgrade.timer", "dpkg-db-backup.timer", "e2scrub_all.timer", "fstrim.timer",
          "e2scrub_reap.service", "getty@tty1.service", "systemd-networkd-wait-online.service")

NETWORK = """[Match]
Name=en* eth*
[Network]
DHCP=ipv4
"""


def missing():
    """The packages whose programs are not here."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    return sorted({package for name, package in NEEDED.items() if shutil.which(name, path=path) is None})


def run(*command, **options):
    """Its standard output. What it said goes into the exception."""
    done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          check=False, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{command[0]} ended with {done.returncode}: {done.stderr[-2000:]}")
    return done.stdout


class Image:
    """folder/disk, folder/vmlinuz and folder/initrd. They are made once, and again when `key` has changed."""

    def __init__(self, folder, deb):
        self.folder = pathlib.Path(folder)
        self._dependencies = dependencies_of(deb)
        self.disk, self.kernel, self.initrd = (self.folder / name for name in ("disk", "vmlinuz", "initrd"))

    def make(self):
        """True if there was something to make."""
        mark = self.folder / "made-of"
        sources = (HERE / name for name in ("image.py", "init.sh", "agent.sh", "agent.service"))
        key = "\n".join([*self._dependencies, *(source.read_text(encoding="utf-8") for source in sources)])
        if mark.exists() and mark.read_text(encoding="utf-8") == key:
            return False
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        kernel = self._unpack_kernel()
        self._make_initrd(kernel)
        self._make_disk(kernel)
        shutil.rmtree(kernel.folder)
        mark.write_text(key, encoding="utf-8")
        return True

    def _unpack_kernel(self):
        name = re.search(r"Depends: (linux-image-\S+)", run("apt-cache", "depends", "linux-image-amd64")).group(1)
        run("apt-get", "download", name, cwd=self.folder)
        (package,) = self.folder.glob("linux-image-*.deb")
        kernel = Kernel(self.folder / "kernel", name.removeprefix("linux-image-"))
        run("dpkg-deb", "-x", package, kernel.folder)
        package.unlink()
        run("depmod", "-b", kernel.folder, kernel.version)
        shutil.copy(kernel.folder / f"boot/vmlinuz-{kernel.version}", self.kernel)
        return kernel

    def _make_initrd(self, kernel):
        root = self.folder / "initrd.d"
        (root / "modules").mkdir(parents=True)
        shutil.copy(shutil.which("busybox"), root / "busybox")
        modules = kernel.modules(BOOT_MODULES)
        for module in modules:
            shutil.copy(module, root / "modules")
        order = "".join(f"{module.name}\n" for module in modules)
        (root / "modules/order").write_text(order, encoding="utf-8")
        shutil.copy(HERE / "init.sh", root / "init")
        (root / "init").chmod(0o755)
        names = "\n".join(str(path.relative_to(root)) for path in root.rglob("*"))
        run("sh", "-c", f"cpio --quiet -o -H newc | gzip -1 >'{self.initrd.absolute()}'", cwd=root, input=names)
        shutil.rmtree(root)

    def _make_disk(self, kernel):
        root = self.folder / "root"
        run("mmdebstrap", "--quiet", "--variant=minbase", "--include=" + ",".join([*PACKAGES, *self._dependencies]),
            release_of_this_machine(), root)
        target = root / "lib/modules" / kernel.version
        for module in kernel.modules(MODULES):
            place = target / module.relative_to(kernel.folder / "lib/modules" / kernel.version)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(module, place)
        for name in ("modules.builtin", "modules.builtin.modinfo", "modules.order"):
            shutil.copy(kernel.folder / "lib/modules" / kernel.version / name, target)
        run("depmod", "-b", root, kernel.version)
        self._configure(root)
        with open(self.disk, "wb") as disk:
            disk.truncate(900 << 20)
        run("mke2fs", "-q", "-t", "ext4", "-O", "^has_journal", "-d", root, self.disk)
        shutil.rmtree(root)

    @staticmethod
    def _configure(root):
        units = root / "etc/systemd/system"
        (root / "etc/hostname").write_text("guest\n", encoding="utf-8")
        (root / "etc/fstab").write_text("", encoding="utf-8")
        (root / "etc/modules-load.d/machine.conf").write_text("virtio_console\nvirtio_net\n", encoding="utf-8")
        (root / "etc/systemd/network/machine.network").write_text(NETWORK, encoding="utf-8")
        shutil.copy(HERE / "agent.sh", root / "usr/local/sbin/agent")
        (root / "usr/local/sbin/agent").chmod(0o755)
        shutil.copy(HERE / "agent.service", units)
        wanted = units / "multi-user.target.wants"
        wanted.mkdir(exist_ok=True)
        (wanted / "agent.service").symlink_to("../agent.service")
        (wanted / "systemd-networkd.service").symlink_to("/lib/systemd/system/systemd-networkd.service")
        for unit in MASKED:
            (units / unit).symlink_to("/dev/null")


class Kernel:
    """An unpacked package of the kernel."""

    def __init__(self, folder, version):
        self.folder, self.version = folder, version

    def modules(self, names):
        """The files of these modules and of all that they need, in the order in which they can be loaded."""
        found = []
        for name in names:
            lines = run("modprobe", "-d", self.folder, "-S", self.version, "--show-depends", name).splitlines()
            for line in lines:
                if line.startswith("insmod ") and pathlib.Path(line.split()[1]) not in found:
                    found.append(pathlib.Path(line.split()[1]))
        return found


def dependencies_of(deb):
    """The names of the packages that it depends on; of alternatives the first."""
    fields = run("dpkg-deb", "-f", deb, "Depends", "Pre-Depends")
    text = re.sub(r"(?m)^\S+: ", "", fields).replace("\n", ",")
    return sorted({re.split(r"[ (|:]", entry.strip())[0] for entry in text.split(",") if entry.strip()})


def release_of_this_machine():
    text = pathlib.Path("/etc/os-release").read_text(encoding="utf-8")
    return re.search(r"(?m)^VERSION_CODENAME=\"?(\w+)", text).group(1)
