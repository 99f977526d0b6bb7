#ifndef PINCH_VIEW_PAGE_TEXTS_H
#define PINCH_VIEW_PAGE_TEXTS_H

/* The files of view/page, which the build puts into the program (embed.cmake). */
extern const char view_style_css[], view_film_js[], view_stage_js[], view_charts_js[], view_viewer_js[], view_run_js[],
    view_report_js[], view_report_css[], view_study_js[], view_study_css[], view_paper_css[];

#endif
