const app = document.getElementById("app");
const show = (text) => { app.textContent = text; };
const socket = new WebSocket(`ws://${location.host}/ws?run=live`);
socket.onmessage = (message) => {
  const frame = JSON.parse(message.data);
  const state = frame.type === "hello" ? frame.state : frame;
  if (state && state.words) show(state.words);
};
socket.onclose = () => show("no connection to the print");
