/* The socket to the server: messages go out as they are, but of what a hand does only the latest in each frame. */

export function connect(hear, gone) {
  const address = new URL("live", location.href);
  address.protocol = "ws:";
  let socket = null, latest = null, wait = 250;

  function open() {
    socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { wait = 250; gone(false); };
    socket.onmessage = (event) => hear(typeof event.data === "string" ? JSON.parse(event.data) : event.data);
    socket.onclose = () => {
      gone(true);
      setTimeout(open, wait);
      wait = Math.min(2 * wait, 8000);
    };
  }

  /* Until the server answers, nothing is known of what comes of it. */
  function post(message) {
    if (socket.readyState !== WebSocket.OPEN) return;
    document.documentElement.dataset.numbers = "asked";
    socket.send(JSON.stringify(message));
  }

  function flush() {
    if (latest === null) return;
    const message = latest;
    latest = null;
    post(message);
  }

  open();
  return {
    /* What must arrive. */
    send(message) {
      flush();
      post(message);
    },
    /* Where the hand is; a later place goes for it. */
    move(message) {
      if (latest === null) requestAnimationFrame(flush);
      latest = message;
    },
  };
}
