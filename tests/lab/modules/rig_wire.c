// SPDX-License-Identifier: GPL-2.0
/*
 * rig_wire - wires and relays between gpio-sim lines, and calls that hang, inside the kernel.
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
 *   "CHIP:LINE open CHIP:LINE MS"  a relay: while the first line is high, the second is
 *                           cut off and reads low; "ground": it is low, "supply":
 *                           high. The contact moves MS after its coil (0: inside
 *                           the call, as a wire does).
 *   "none"                  cuts them all, relays too
 * The level present is put on the input at once. Releasing an output leaves
 * the input as it was last driven, and so does a relay that lets go of a line
 * without a wire. A wired chip must not be taken away.
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
#include <linux/workqueue.h>

#define MAX_CHIPS 4
#define MAX_WIRES 64
#define MAX_RELAYS 16
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
static const char *const way_names[] = { "open", "ground", "supply" };
static struct relay {
	struct end by, on;
	unsigned int way, ms;
	bool coil, contact;
	bool rest;	/* the level before, of a line without a wire */
	struct delayed_work work;
} relays[MAX_RELAYS];
static unsigned int n_relays;
static DEFINE_MUTEX(lock);	/* gpio-sim's callbacks may sleep anyway */

static void pull(const struct end *end, bool up)
{
	unsigned int pull = up ? PIN_CONFIG_BIAS_PULL_UP : PIN_CONFIG_BIAS_PULL_DOWN;

	end->chip->gc->set_config(end->chip->gc, end->line, PIN_CONF_PACKED(pull, 1));
}

static bool same(const struct end *a, const struct end *b)
{
	return a->chip == b->chip && a->line == b->line;
}

/* the relay whose contact has the line, if any: the first beats the others */
static struct relay *faulty(const struct end *end)
{
	unsigned int i;

	for (i = 0; i < n_relays; i++)
		if (relays[i].contact && same(&relays[i].on, end))
			return &relays[i];
	return NULL;
}

static void drive(const struct wire *w, bool level)
{
	if (!faulty(&w->to))
		pull(&w->to, level != w->invert);
}

/* a contact has moved: the line is what relays and wires make of it now */
static void settle(struct relay *r)
{
	struct relay *f = faulty(&r->on);
	unsigned int i;

	if (f) {
		pull(&f->on, f->way == 2);
		return;
	}
	for (i = 0; i < n_wires; i++)
		if (same(&wires[i].to, &r->on)) {
			struct end *from = &wires[i].from;

			drive(&wires[i], from->chip->get(from->chip->gc, from->line));
			return;
		}
	pull(&r->on, r->rest);
}

static void move_contact(struct relay *r)
{
	if (r->contact == r->coil)
		return;
	if (r->coil && !faulty(&r->on))
		r->rest = r->on.chip->get(r->on.chip->gc, r->on.line);
	r->contact = r->coil;
	settle(r);
}

static void relay_work(struct work_struct *work)
{
	struct relay *r = container_of(to_delayed_work(work), struct relay, work);

	mutex_lock(&lock);
	if (r - relays < n_relays)
		move_contact(r);
	mutex_unlock(&lock);
}

static void energise(struct hooked *chip, unsigned int line, bool on)
{
	unsigned int i;

	for (i = 0; i < n_relays; i++) {
		struct relay *r = &relays[i];

		if (r->by.chip != chip || r->by.line != line || r->coil == on)
			continue;
		r->coil = on;
		if (r->ms)
			mod_delayed_work(system_highpri_wq, &r->work, msecs_to_jiffies(r->ms));
		else
			move_contact(r);
	}
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
	for_each_set_bit(i, mask, gc->ngpio)
		energise(hooked_of(gc), i, test_bit(i, bits));
}

static void follow_one(struct gpio_chip *gc, unsigned int offset, int value)
{
	unsigned int i;

	for (i = 0; i < n_wires; i++)
		if (wires[i].from.chip->gc == gc && wires[i].from.line == offset)
			drive(&wires[i], value);
	energise(hooked_of(gc), offset, value);
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
	n_relays = 0;
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
	for (i = 0; i < n_relays; i++) {
		struct relay *r = &relays[i];

		n += sysfs_emit_at(buf, n, "%s:%u %s %s:%u %u\n", r->by.chip->gc->label,
				   r->by.line, way_names[r->way], r->on.chip->gc->label,
				   r->on.line, r->ms);
	}
	mutex_unlock(&lock);
	return n;
}

static void cut_all(void)
{
	unsigned int i;

	mutex_lock(&lock);
	n_wires = 0;
	n_relays = 0;
	mutex_unlock(&lock);
	for (i = 0; i < MAX_RELAYS; i++)
		cancel_delayed_work_sync(&relays[i].work);
}

static int add_relay(char *by, const char *way, char *on, unsigned int ms)
{
	struct relay *r = &relays[n_relays];
	int e;

	if (n_relays == MAX_RELAYS)
		return -ENOSPC;
	e = match_string(way_names, ARRAY_SIZE(way_names), way);
	if (e < 0 || ms > MAX_STALL_MS)
		return -EINVAL;
	r->way = e;
	r->ms = ms;
	e = parse_end(by, &r->by) ?: parse_end(on, &r->on);
	if (e)
		return e;
	r->contact = false;
	r->coil = r->by.chip->get(r->by.chip->gc, r->by.line);
	n_relays++;
	move_contact(r);
	return 0;
}

static ssize_t wires_store(struct device *d, struct device_attribute *a,
			   const char *buf, size_t n)
{
	char from[40], to[40], on[40];
	struct wire w = {};
	unsigned int ms;
	int e;

	if (sysfs_streq(buf, "none")) {
		cut_all();
		return n;
	}
	e = sscanf(buf, "%39s %39s %39s %u", from, to, on, &ms);
	if (e == 4) {
		mutex_lock(&lock);
		e = add_relay(from, to, on, ms);
		mutex_unlock(&lock);
		return e ?: n;
	}
	if (e != 2)
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
	unsigned int i;
	int e;

	for (i = 0; i < MAX_RELAYS; i++)
		INIT_DELAYED_WORK(&relays[i].work, relay_work);
	e = platform_driver_register(&rig_driver);
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
	cut_all();
	unhook_all();
}

module_init(rig_init);
module_exit(rig_exit);
MODULE_DESCRIPTION("Wires between gpio-sim lines, and calls on them that hang");
MODULE_LICENSE("GPL");
