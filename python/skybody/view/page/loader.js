// Turns the modules inside the page into importable addresses, in order, and starts ./main.js.
// A page that was opened from the file system may not import files beside it.
(async () => {
  const say = (text) => {
    const place = document.getElementById("message");
    place.textContent = text;
    place.hidden = false;
  };
  addEventListener("error", (event) => say(`${event.message}`));
  addEventListener("unhandledrejection", (event) => say(`${event.reason}`));
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const inflate = async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  };
  const addresses = new Map();
  for (const module of read("modules")) {
    let text = module.text ?? new TextDecoder().decode(await inflate(module.gzip));
    for (const [name, address] of addresses) {
      text = text.replaceAll(`from '${name}'`, `from '${address}'`);
      text = text.replaceAll(`from "${name}"`, `from "${address}"`);
    }
    addresses.set(module.name, URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
  }
  const { start } = await import(addresses.get("./main.js"));
  const packed = document.getElementById("packed").textContent;
  await start(read("content"), packed === "" ? new ArrayBuffer(0) : await inflate(packed));
})();
