"""A real Chromium without a screen, drawing in software, for tests and pictures."""
import contextlib

from selenium import webdriver
from selenium.webdriver.chrome.service import Service


@contextlib.contextmanager
def browser(width=1280, height=800, dark=False, scale=1, phone=False):
    """A driver that is closed in any case. What the page's console said is in driver.get_log("browser")."""
    options = webdriver.ChromeOptions()
    # As root, and in containers, Chromium's own sandbox does not start; it loads only pages of this machine here.
    for argument in ("--headless=new", "--disable-gpu", "--no-sandbox", "--disable-dev-shm-usage", f"--window-size={width},{height + 139}", f"--force-device-scale-factor={scale}", "--hide-scrollbars"):
        options.add_argument(argument)
    if dark:
        options.add_argument("--force-dark-mode")
        options.add_argument("--blink-settings=preferredColorScheme=0")
    if phone:
        options.add_experimental_option("mobileEmulation", {"deviceMetrics": {"width": width, "height": height, "pixelRatio": 2, "touch": True}})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    try:
        if not phone:
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": False})
        yield driver
    finally:
        driver.quit()
