// Boxes that scroll can be reached by keyboard, and the buttons of each block of code have a name of their own.
const named = () => {
  document.querySelectorAll(".md-typeset__scrollwrap, math[display=block]").forEach((box) => (box.tabIndex = 0));
  document.querySelectorAll("nav.md-code__nav").forEach((nav, number) => (nav.ariaLabel = `Code ${number + 1}`));
};
new MutationObserver(named).observe(document.body, { childList: true, subtree: true });
named();
