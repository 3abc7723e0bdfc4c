// Unpacks the browser of `make test-browser` into TMPDIR; run where the package is installed.
import chromium from "@sparticuz/chromium";

console.log(await chromium.executablePath());
