// Inside Meshcat's page: the sky is as light or dark as the page around it, or as the reader's choice.
const SKIES = { light: ["#f7fafc", "#d6dbdf"], dark: ["#1b222b", "#0d1117"] };

function sky(name) {
  ["top_color", "bottom_color"].forEach((property, i) => {
    const value = [1, 3, 5].map(k => parseInt(SKIES[name][i].slice(k, k + 2), 16) / 255);
    viewer.handle_command({ type: "set_property", path: "/Background/<object>", property, value });
  });
}

const choice = matchMedia("(prefers-color-scheme: dark)");
const asChosen = () => sky(choice.matches ? "dark" : "light");
choice.addEventListener("change", asChosen);
asChosen();
