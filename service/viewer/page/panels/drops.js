/**
 * Lets files be dropped on an element, which has a class while some are over it.
 *
 * @param {HTMLElement} element
 * @param {(files: File[]) => void} onFiles
 * @param {() => boolean} [isAllowed] whether files are taken now
 */
export function takeFiles(element, onFiles, isAllowed = () => true) {
  let depth = 0; // of entered elements
  /** @param {string} type @param {(event: DragEvent) => void} handle */
  const onDrag = (type, handle) => element.addEventListener(type, (event) => {
    const drag = /** @type {DragEvent} */ (event);
    if (!drag.dataTransfer?.types.includes('Files')) return;
    drag.preventDefault(); // the browser would leave the page for the file
    handle(drag);
    element.classList.toggle('dropping', depth > 0 && isAllowed());
    element.classList.toggle('refusing', depth > 0 && !isAllowed());
  });
  onDrag('dragenter', () => { depth += 1; });
  onDrag('dragleave', () => { depth = Math.max(0, depth - 1); });
  onDrag('dragover', ({ dataTransfer }) => {
    if (dataTransfer) dataTransfer.dropEffect = isAllowed() ? 'copy' : 'none';
  });
  onDrag('drop', ({ dataTransfer }) => {
    depth = 0;
    if (isAllowed()) onFiles([...dataTransfer?.files ?? []]);
  });
}
