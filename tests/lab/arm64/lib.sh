# shellcheck shell=bash
# Common to cross, build-image and run; sourced, not run.

ARM64=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$ARM64/../lib.sh"
CACHE=$CACHE/arm64
KERNEL_PACKAGE=${RIG_LAB_ARM64_KERNEL:-linux-image-arm64}
# Loaded when the guest starts, in the order of their dependencies.
MODULES="9p 9pnet_virtio virtio_pci virtio_console can-raw can-bcm can-isotp vcan kvaser_pci i6300esb"
# In /lib/modules, loaded by nobody.
SPARE_MODULES="softdog slcan"

# Names for "what this checkout asks for", so a stale image is never taken for a
# good one. A change of the guest's init alone does not fetch the kernel again.
image_id() { # extra file...
	{ echo "$KERNEL_PACKAGE $MODULES $SPARE_MODULES"; cat "$ARM64/build-image" "$@"; } |
		sha256sum | cut -c1-12
}
kernel_dir() { echo "$CACHE/kernel-$(image_id)"; }
system_image() { echo "$CACHE/system-$(image_id "$ARM64"/guest/* "$LAB"/guest/common).cpio.gz"; }
initramfs_image() { echo "$CACHE/initramfs-$(image_id "$ARM64"/guest/* "$LAB"/guest/common).cpio.gz"; }

end_setup() {
	rm -rf "$work"
	trap - EXIT
	exec 9>&-
}

# apt with arm64 beside amd64 and package lists of its own: the machine's lists
# and dpkg's architectures stay as they are, and no root is needed. Neither are
# the machine's hooks run: those of containers delete the packages that another
# apt is about to install.
foreign() { # apt-get|apt-cache argument...
	local tool=$1 d=$work/apt
	shift
	"$tool" -c "$d/no-hooks" -o APT::Architecture=amd64 -o APT::Architectures::=amd64 -o APT::Architectures::=arm64 \
		-o Dir::State="$d" -o Dir::State::lists="$d/lists" -o Dir::State::status=/var/lib/dpkg/status \
		-o Dir::Cache="$d" -o APT::Sandbox::User=root -o Acquire::Languages=none \
		-o Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false "$@"
}

# A list that fails must not go unnoticed: without the security suite's an older
# compiler would be taken.
foreign_lists() {
	mkdir -p "$work/apt/lists/partial" "$work/apt/archives/partial"
	printf '#clear %s;\n' APT::Update::{Pre-Invoke,Post-Invoke,Post-Invoke-Success} DPkg::{Pre-Invoke,Post-Invoke} \
		>"$work/apt/no-hooks"
	foreign apt-get -qq -o APT::Update::Error-Mode=any update >"$CACHE/apt.log" 2>&1 ||
		die "apt-get update failed, try again; see $CACHE/apt.log"
}

# First package named $2... in the dependencies of $1.
dependency() {
	foreign apt-cache show --no-all-versions "$1" |
		sed -n 's/^Depends: //p' | tr ',' '\n' | sed -n "s/^ *\($2[^ ]*\).*/\1/p" | sed 1q
}

# Downloads packages and unpacks them side by side into $1.
unpack() {
	local into=$1 deb
	shift
	rm -rf "$work/debs"
	mkdir -p "$work/debs" "$into"
	(cd "$work/debs" && foreign apt-get -qq download "$@" 2>"$CACHE/apt.log") ||
		die "download failed, see $CACHE/apt.log"
	for deb in "$work"/debs/*.deb; do
		dpkg-deb -x "$deb" "$into"
	done
	rm -rf "$work/debs"
}
