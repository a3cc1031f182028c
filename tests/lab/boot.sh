# shellcheck shell=bash
# What `run` of either machine does once it knows what to boot; sourced, not run.
# The options are in $limit, $mem, $cpus, $reboots, $keep, $quiet and env=(...).

# Leaves $ctl, the folder that the guest has as /ctl; removed on exit.
begin_run() {
	ctl=$(mktemp -d "${TMPDIR:-/tmp}/rig-lab.XXXXXX")
	pid= cat_pid=
	trap cleanup EXIT
	trap 'exit 130' INT
	trap 'exit 143' TERM HUP
}
cleanup() {
	local p
	for p in $pid $cat_pid; do
		kill "$p" 2>/dev/null || true
		wait "$p" 2>/dev/null || true
	done
	rm -rf "$ctl"
}

# Boots a machine with $dir as /job, runs a command in it and exits with its code.
#
#   boot QEMU QEMU-ARGUMENT... -- COMMAND...
#
# Both machines have a CAN bus with two controllers; two dual-port serial cards
# whose ports are joined crosswise by sockets; an i6300esb watchdog that resets
# them; one virtio port for the job's output.
boot() {
	local qemu=$1 args=() e rc start end qemu_rc=0
	shift
	while [ "$1" != -- ]; do
		args+=("$1")
		shift
	done
	shift
	{
		for e in ${env[@]+"${env[@]}"}; do
			printf 'export %q\n' "$e"
		done
		printf 'exec'
		printf ' %q' "$@"
		echo
	} >"$ctl/cmd"
	args+=(
		-nodefaults -no-user-config -display none -smp "$cpus" -m "$mem"
		-serial "file:$ctl/console"
		-fsdev "local,id=ctl,path=${ctl//,/,,},security_model=none"
		-device virtio-9p-pci,fsdev=ctl,mount_tag=ctl
		-fsdev "local,id=job,path=${dir//,/,,},security_model=none"
		-device virtio-9p-pci,fsdev=job,mount_tag=job
		-device virtio-serial-pci
		-chardev "file,id=job,path=$ctl/out" -device virtserialport,chardev=job,name=job
		-object can-bus,id=bus0
		-device kvaser_pci,canbus=bus0 -device kvaser_pci,canbus=bus0
		-chardev "socket,id=a,path=$ctl/ab,server=on,wait=off" -chardev "socket,id=b,path=$ctl/ab"
		-chardev "socket,id=c,path=$ctl/cd,server=on,wait=off" -chardev "socket,id=d,path=$ctl/cd"
		-device pci-serial-2x,chardev1=a,chardev2=c,addr=0x0a
		-device pci-serial-2x,chardev1=b,chardev2=d,addr=0x0b
		-device i6300esb -action watchdog=reset
	)
	[ "$reboots" -gt 0 ] || args+=(-no-reboot)

	# The job's output passes through a FIFO of our own: QEMU sets its end
	# non-blocking, which must not reach whatever our caller's standard output is.
	mkfifo "$ctl/out"
	exec 3<>"$ctl/out"
	cat <"$ctl/out" 3>&- &
	cat_pid=$!

	start=$(date +%s.%N)
	timeout --foreground -k 5 "$limit" "$qemu" "${args[@]}" \
		</dev/null >/dev/null 2>"$ctl/qemu.err" 3>&- &
	pid=$!
	wait "$pid" || qemu_rc=$?
	pid=
	exec 3>&-
	wait "$cat_pid" || true
	cat_pid=
	end=$(date +%s.%N)

	[ -z "$keep" ] || cp "$ctl/console" "$keep"
	if [ -s "$ctl/rc" ]; then
		rc=$(cat "$ctl/rc")
	elif [ "$qemu_rc" = 124 ] || [ "$qemu_rc" = 137 ]; then
		echo "run: time is up after $limit s" >&2
		show_console
		rc=124
	elif [ ! -e "$ctl/ready" ]; then
		echo "run: the guest did not come up" >&2
		show_console
		rc=125
	else
		echo "run: the guest stopped before the command ended (reset or panic)" >&2
		show_console
		rc=126
	fi
	if [ -s "$ctl/trouble" ]; then
		echo "run: the lab came up incomplete:" >&2
		sed 's/^/  /' "$ctl/trouble" >&2
		[ "$rc" != 0 ] || rc=125
	fi
	[ $quiet = yes ] || awk -v s="$start" -v e="$end" -v r="$rc" \
		-v u="$(cat "$ctl/ready" 2>/dev/null || echo '?')" \
		'BEGIN { printf "run: exit %s, guest ready at %s s, %.1f s in all\n", r, u, e - s }' >&2
	exit "$rc"
}

show_console() {
	echo "--- last lines of the guest's console:" >&2
	tail -n 20 "$ctl/console" 2>/dev/null | tr -d '\r' >&2
	cat "$ctl/qemu.err" >&2
}
