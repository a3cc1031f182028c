// SPDX-License-Identifier: GPL-2.0
/*
 * rig_wire - wires between gpio-sim lines, and calls that hang, inside the kernel.
 *
 * A gpio-sim output notifies nobody, and its inputs are set through sysfs, so
 * a loop from output to input takes a polling program. Here the chip's own
 * "set" callbacks are wrapped: whoever sets an output line sets the input
 * lines wired to it before the call returns. The input is driven by
 * gpio-sim's set_config callback, which does just what a write to "pull" does,
 * edge interrupt included.
 *
 * /sys/devices/platform/rig-wire/wires (rw): read lists them; write
 *   "CHIP:LINE CHIP:LINE"   a wire from output to input, chips by label
 *   "CHIP:LINE !CHIP:LINE"  the same with an inverter
 *   "none"                  cuts them all
 * The level present is put on the input at once. Releasing an output leaves
 * the input as it was last driven. A wired chip must not be taken away.
 *
 * /sys/devices/platform/rig-wire/stall (rw): a bus behind the chip that hangs.
 *   "CHIP get MS TIMES"   the next TIMES calls that read lines of the chip sleep
 *                         for MS before they do; "set": calls that set lines
 *   "none"                no further call does (those inside sleep on)
 * The sleep cannot be interrupted, as that of a bus driver cannot. Edges of the
 * chip's lines and wires go on meanwhile. Read: a line per chip and call with
 * "CHIP CALL MS LEFT INSIDE", the last being how many calls sleep just now.
 */
#include <linux/delay.h>
#include <linux/device.h>
#include <linux/gpio/driver.h>
#include <linux/module.h>
#include <linux/mutex.h>
#include <linux/pinctrl/pinconf-generic.h>
#include <linux/platform_device.h>
#include <linux/sysfs.h>

#define MAX_CHIPS 4
#define MAX_WIRES 64
#define MAX_STALL_MS 60000

enum { GET, SET, CALLS };
static const char *const call_names[CALLS] = { "get", "set" };

struct stall {
	unsigned int ms;
	atomic_t left;
	atomic_t inside;
};

struct hooked {
	struct gpio_device *gdev;
	struct gpio_chip *gc;
	void (*set)(struct gpio_chip *gc, unsigned int offset, int value);
	void (*set_multiple)(struct gpio_chip *gc, unsigned long *mask, unsigned long *bits);
	int (*direction_output)(struct gpio_chip *gc, unsigned int offset, int value);
	int (*get)(struct gpio_chip *gc, unsigned int offset);
	int (*get_multiple)(struct gpio_chip *gc, unsigned long *mask, unsigned long *bits);
	struct stall stalls[CALLS];
};

struct end {
	struct hooked *chip;
	unsigned int line;
};

static struct hooked chips[MAX_CHIPS];
static struct wire {
	struct end from, to;
	bool invert;
} wires[MAX_WIRES];
static unsigned int n_wires;
static DEFINE_MUTEX(lock);	/* gpio-sim's callbacks may sleep anyway */

static void drive(const struct wire *w, bool level)
{
	unsigned int pull = level != w->invert ? PIN_CONFIG_BIAS_PULL_UP :
						 PIN_CONFIG_BIAS_PULL_DOWN;

	w->to.chip->gc->set_config(w->to.chip->gc, w->to.line, PIN_CONF_PACKED(pull, 1));
}

static struct hooked *hooked_of(struct gpio_chip *gc)
{
	unsigned int i;

	for (i = 0; chips[i].gc != gc; i++)
		;
	return &chips[i];
}

/* lines in "mask" of the chip have just been set to "bits" */
static void follow(struct gpio_chip *gc, unsigned long *mask, unsigned long *bits)
{
	unsigned int i;

	for (i = 0; i < n_wires; i++)
		if (wires[i].from.chip->gc == gc && test_bit(wires[i].from.line, mask))
			drive(&wires[i], test_bit(wires[i].from.line, bits));
}

static void follow_one(struct gpio_chip *gc, unsigned int offset, int value)
{
	unsigned int i;

	for (i = 0; i < n_wires; i++)
		if (wires[i].from.chip->gc == gc && wires[i].from.line == offset)
			drive(&wires[i], value);
}

/* Outside of the lock: a chip that hangs does not hold up another one. */
static struct hooked *stalled(struct gpio_chip *gc, int call)
{
	struct hooked *h = hooked_of(gc);
	struct stall *s = &h->stalls[call];

	if (atomic_dec_if_positive(&s->left) >= 0) {
		atomic_inc(&s->inside);
		msleep(READ_ONCE(s->ms));
		atomic_dec(&s->inside);
	}
	return h;
}

static int hook_get(struct gpio_chip *gc, unsigned int offset)
{
	return stalled(gc, GET)->get(gc, offset);
}

static int hook_get_multiple(struct gpio_chip *gc, unsigned long *mask, unsigned long *bits)
{
	return stalled(gc, GET)->get_multiple(gc, mask, bits);
}

static void hook_set(struct gpio_chip *gc, unsigned int offset, int value)
{
	struct hooked *h = stalled(gc, SET);

	mutex_lock(&lock);
	h->set(gc, offset, value);
	follow_one(gc, offset, value);
	mutex_unlock(&lock);
}

static void hook_set_multiple(struct gpio_chip *gc, unsigned long *mask, unsigned long *bits)
{
	struct hooked *h = stalled(gc, SET);

	mutex_lock(&lock);
	h->set_multiple(gc, mask, bits);
	follow(gc, mask, bits);
	mutex_unlock(&lock);
}

static int hook_direction_output(struct gpio_chip *gc, unsigned int offset, int value)
{
	int e;

	mutex_lock(&lock);
	e = hooked_of(gc)->direction_output(gc, offset, value);
	if (!e)
		follow_one(gc, offset, value);
	mutex_unlock(&lock);
	return e;
}

/* Find the chip and wrap its callbacks; they stay wrapped until unload. */
static struct hooked *hook(const char *label)
{
	struct gpio_device *gdev = gpio_device_find_by_label(label);
	struct hooked *h = NULL;
	struct gpio_chip *gc;
	unsigned int i;

	if (!gdev)
		return ERR_PTR(-ENODEV);
	gc = gpio_device_get_chip(gdev);
	for (i = 0; !h && i < MAX_CHIPS; i++)
		if (!chips[i].gc || chips[i].gdev == gdev)
			h = &chips[i];
	if (!h || h->gc || !gc->set || !gc->set_multiple || !gc->direction_output ||
	    !gc->get || !gc->get_multiple || !gc->set_config || !gc->can_sleep) {
		gpio_device_put(gdev);
		return !h ? ERR_PTR(-ENOSPC) : h->gc ? h : ERR_PTR(-EOPNOTSUPP);
	}
	*h = (struct hooked) {
		.gdev = gdev, .gc = gc, .set = gc->set, .set_multiple = gc->set_multiple,
		.direction_output = gc->direction_output,
		.get = gc->get, .get_multiple = gc->get_multiple,
	};
	gc->set = hook_set;
	gc->set_multiple = hook_set_multiple;
	gc->direction_output = hook_direction_output;
	gc->get = hook_get;
	gc->get_multiple = hook_get_multiple;
	return h;
}

static void unhook_all(void)
{
	unsigned int i;

	mutex_lock(&lock);
	n_wires = 0;
	for (i = 0; i < MAX_CHIPS && chips[i].gc; i++) {
		chips[i].gc->set = chips[i].set;
		chips[i].gc->set_multiple = chips[i].set_multiple;
		chips[i].gc->direction_output = chips[i].direction_output;
		chips[i].gc->get = chips[i].get;
		chips[i].gc->get_multiple = chips[i].get_multiple;
		gpio_device_put(chips[i].gdev);
	}
	mutex_unlock(&lock);
}

/* ---- sysfs ------------------------------------------------------------------ */

static int parse_end(char *s, struct end *end)
{
	char *line = strrchr(s, ':');

	if (!line)
		return -EINVAL;
	*line++ = '\0';
	if (kstrtouint(line, 10, &end->line))
		return -EINVAL;
	end->chip = hook(s);
	if (IS_ERR(end->chip))
		return PTR_ERR(end->chip);
	return end->line < end->chip->gc->ngpio ? 0 : -EINVAL;
}

static ssize_t wires_show(struct device *d, struct device_attribute *a, char *buf)
{
	unsigned int i;
	int n = 0;

	mutex_lock(&lock);
	for (i = 0; i < n_wires; i++) {
		struct wire *w = &wires[i];

		n += sysfs_emit_at(buf, n, "%s:%u %s%s:%u\n", w->from.chip->gc->label,
				   w->from.line, w->invert ? "!" : "",
				   w->to.chip->gc->label, w->to.line);
	}
	mutex_unlock(&lock);
	return n;
}

static ssize_t wires_store(struct device *d, struct device_attribute *a,
			   const char *buf, size_t n)
{
	char from[40], to[40];
	struct wire w = {};
	int e;

	if (sysfs_streq(buf, "none")) {
		mutex_lock(&lock);
		n_wires = 0;
		mutex_unlock(&lock);
		return n;
	}
	if (sscanf(buf, "%39s %39s", from, to) != 2)
		return -EINVAL;
	w.invert = to[0] == '!';
	mutex_lock(&lock);
	e = parse_end(from, &w.from) ?: parse_end(to + w.invert, &w.to);
	if (!e && n_wires == MAX_WIRES)
		e = -ENOSPC;
	if (!e && w.from.chip == w.to.chip && w.from.line == w.to.line)
		e = -EINVAL;
	if (!e) {
		wires[n_wires++] = w;
		drive(&w, w.from.chip->get(w.from.chip->gc, w.from.line));
	}
	mutex_unlock(&lock);
	return e ?: n;
}
static DEVICE_ATTR_RW(wires);

static ssize_t stall_show(struct device *d, struct device_attribute *a, char *buf)
{
	unsigned int i, c;
	int n = 0;

	mutex_lock(&lock);
	for (i = 0; i < MAX_CHIPS && chips[i].gc; i++)
		for (c = 0; c < CALLS; c++) {
			struct stall *s = &chips[i].stalls[c];

			n += sysfs_emit_at(buf, n, "%s %s %u %d %d\n", chips[i].gc->label,
					   call_names[c], s->ms, atomic_read(&s->left),
					   atomic_read(&s->inside));
		}
	mutex_unlock(&lock);
	return n;
}

static void stall_none(void)
{
	unsigned int i, c;

	for (i = 0; i < MAX_CHIPS && chips[i].gc; i++)
		for (c = 0; c < CALLS; c++)
			atomic_set(&chips[i].stalls[c].left, 0);
}

static ssize_t stall_store(struct device *d, struct device_attribute *a,
			   const char *buf, size_t n)
{
	unsigned int ms, times;
	char label[40], call[4];
	struct hooked *h;
	int c, e = 0;

	if (sysfs_streq(buf, "none")) {
		mutex_lock(&lock);
		stall_none();
		mutex_unlock(&lock);
		return n;
	}
	if (sscanf(buf, "%39s %3s %u %u", label, call, &ms, &times) != 4 ||
	    ms > MAX_STALL_MS || times > INT_MAX)
		return -EINVAL;
	c = match_string(call_names, CALLS, call);
	if (c < 0)
		return -EINVAL;
	mutex_lock(&lock);
	h = hook(label);
	if (IS_ERR(h)) {
		e = PTR_ERR(h);
	} else {
		WRITE_ONCE(h->stalls[c].ms, ms);
		atomic_set(&h->stalls[c].left, times);
	}
	mutex_unlock(&lock);
	return e ?: n;
}
static DEVICE_ATTR_RW(stall);

static struct attribute *wire_attrs[] = { &dev_attr_wires.attr, &dev_attr_stall.attr, NULL };
ATTRIBUTE_GROUPS(wire);

static int rig_probe(struct platform_device *pdev)
{
	return 0;
}

static struct platform_driver rig_driver = {
	.probe = rig_probe,
	.driver = { .name = "rig-wire", .dev_groups = wire_groups },
};

static struct platform_device *rig_dev;

static int __init rig_init(void)
{
	int e = platform_driver_register(&rig_driver);

	if (e)
		return e;
	rig_dev = platform_device_register_simple("rig-wire", PLATFORM_DEVID_NONE, NULL, 0);
	if (IS_ERR(rig_dev)) {
		platform_driver_unregister(&rig_driver);
		return PTR_ERR(rig_dev);
	}
	return 0;
}

static void __exit rig_exit(void)
{
	platform_device_unregister(rig_dev);
	platform_driver_unregister(&rig_driver);
	unhook_all();
}

module_init(rig_init);
module_exit(rig_exit);
MODULE_DESCRIPTION("Wires between gpio-sim lines, and calls on them that hang");
MODULE_LICENSE("GPL");
