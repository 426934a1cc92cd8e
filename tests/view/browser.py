"""Headless Chromium, driven by Debian's Selenium."""

import os
import shutil
import sys

DEBIANS_PYTHON = "/usr/bin/python3"

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    if os.path.realpath(sys.executable) != os.path.realpath(DEBIANS_PYTHON) and os.path.exists(DEBIANS_PYTHON):
        os.execv(DEBIANS_PYTHON, [DEBIANS_PYTHON, "-B", *sys.argv])  # which has Debian's packages
    raise


def open_chromium(size, *flags, logs=None):
    """size: of the window, "1440,960". logs: what Chromium is to log, and how much, if anything."""
    options = webdriver.ChromeOptions()
    for flag in ("--headless=new", "--no-sandbox", f"--window-size={size}", "--hide-scrollbars", *flags):
        options.add_argument(flag)
    if logs:
        options.set_capability("goog:loggingPrefs", logs)
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
