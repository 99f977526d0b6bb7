void exec_nothing(void);void exec_nothing(void){}
