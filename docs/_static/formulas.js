// Formulas are in the page as TeX; KaTeX, which lies beside it, draws them.
document.addEventListener("DOMContentLoaded", () => {
  for (const element of document.querySelectorAll(".math.tex")) {
    katex.render(element.textContent, element, {
      displayMode: element.tagName === "DIV",
      throwOnError: false,
      macros: {
        "\\vec": "\\boldsymbol{#1}",
        "\\T": "\\mathsf{T}",
        "\\d": "\\mathrm{d}",
        "\\mat": "\\mathbf{#1}",
      },
    });
  }
});
