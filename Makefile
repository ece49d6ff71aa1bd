# Two commands do everything, their own set-up included: `make demo` and `make test`. `make help` lists the rest.
# One profile (dev: our code lightly, the dependencies fully optimised) and one target folder serve all of them.

SHELL := /bin/sh
export PATH := $(PATH):$(HOME)/.cargo/bin
export CARGO_NET_RETRY ?= 10
# Window systems and drivers want a private folder; a bare machine has none.
ifeq ($(XDG_RUNTIME_DIR),)
export XDG_RUNTIME_DIR := $(CURDIR)/target/runtime
endif

SCENE ?= scenes/fish.toml
PICTURE ?= target/demo.png
MURRINE := cargo run --locked --quiet --bin murrine --

.PHONY: help demo picture test style claims assets golden bench fuzz setup-demo setup-test runtime

help: ## this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1|\2/p' Makefile | awk -F'|' '{ printf "%-15s %s\n", $$1, $$2 }'

demo: setup-demo ## open the window on our best scene; without a display, render a picture
	@cargo build --locked --bin murrine
	@if [ -n "$${DISPLAY:-}$${WAYLAND_DISPLAY:-}" ]; then \
		$(MURRINE) $(SCENE); \
	else \
		echo "no display: rendering a picture instead"; \
		$(MAKE) --no-print-directory picture; \
	fi

picture: setup-demo ## render SCENE to PICTURE
	@$(MURRINE) render $(SCENE) --size 1152x768 -o $(PICTURE)
	@echo "the picture: $(abspath $(PICTURE))"

test: setup-test style claims ## every check: style, lints, claims, golden frames

style:
	@if cargo fmt --version >/dev/null 2>&1; then cargo fmt --all -- --check; else echo "rustfmt is missing: style NOT checked"; fi
	@if cargo clippy --version >/dev/null 2>&1; then cargo clippy --locked --quiet --all-targets -- -D warnings; \
		else echo "clippy is missing: lints NOT checked"; fi

claims: runtime
	cargo test --locked

assets: ## make the models in assets/ again
	cargo run --locked --quiet --example assets

golden: setup-demo ## compare the golden frames in screenshots/ (ARGS=update to bless them)
	@$(MURRINE) golden $(or $(ARGS),run)

bench: setup-demo ## time every stage (ARGS are passed on)
	@$(MURRINE) bench $(ARGS)

fuzz: setup-test ## feed 100,000 broken files to each reader
	@for reader in model scene environment voxels; do cargo run --locked --quiet --example fuzz -- $$reader || exit 1; done

setup-demo: runtime
	@sh tools/setup.sh demo

setup-test: runtime
	@sh tools/setup.sh test style

runtime:
	@mkdir -p -m 700 "$$XDG_RUNTIME_DIR"
