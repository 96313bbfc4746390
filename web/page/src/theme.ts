// SPDX-License-Identifier: BSD-3-Clause
// Light or dark, and the colours of it. Without Lit: the 3D view is a script of its own.

/** The user's choice, else the system's. */
export function theme(): 'light' | 'dark' {
  const chosen = document.documentElement.dataset.theme;
  if (chosen === 'light' || chosen === 'dark') return chosen;
  return matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark';
}

/** Those who draw with colours of the theme look again. */
export const themeListeners = new Set<() => void>();

export function setTheme(to: 'light' | 'dark'): void {
  document.documentElement.dataset.theme = to;
  for (const listener of themeListeners) listener();
}

/** A colour of the theme. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
