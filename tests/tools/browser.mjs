// Headless Chromium for the tools of this folder, with WebGL in software and without background traffic.
import { existsSync } from "node:fs";

const skip = (reason) => { console.log(reason); process.exit(77); };

/** A browser of playwright-core over the system's Chromium. Ends the program with status 77 and a reason where a tool is absent. */
export async function launch() {
  const places = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
  const executablePath = places.find((place) => place && existsSync(place));
  if (!executablePath) skip("there is no Chromium");
  const playwright = await import("playwright-core").catch(() => skip("tests/tools has no playwright-core; run npm ci there"));
  return playwright.chromium.launch({
    executablePath,
    args: ["--headless", "--no-sandbox", "--disable-background-networking", "--use-gl=angle", "--use-angle=swiftshader"],
  });
}
